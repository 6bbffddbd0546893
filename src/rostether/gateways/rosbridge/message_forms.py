"""Converts messages to the forms of clients, once for all clients with the same form."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from rostether.gateways.rosbridge.client_subscription import Compression
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.png_packing import pack_png
from rostether.gateways.rosbridge.values import JsonForm, JsonText
from rostether.gateways.shared_subscriptions import Batch
from rostether.rostime import Time
from rostether.serde.store import TypeStore

if TYPE_CHECKING:
    from rostether.gateways.rosbridge.cbor import CborForm
    from rostether.gateways.rosbridge.request import Request
    from rostether.ros2.types.type_support import Ros2Types

# Each value may be an empty object that becomes a message: a marker takes 20 µs.
_FEW_VALUES: Final = 1024

# Larger messages may take longer than 10 ms, and are converted in a thread.
_MAX_QUICK_BYTES: Final = 64 << 10


class MessageForms:
    """Converts between payloads and the protocol's messages; `now` is the graph's time."""

    def __init__(self, store: TypeStore, style: Style, now: Callable[[], Time]) -> None:
        self._store = store
        self._style = style
        self._json = JsonForm(style)
        self._now = now

    def to_json(self, type_name: str, payload: bytes) -> dict[str, Any]:
        """Return a payload of a known type as a JSON value. Raises SerializationError."""
        return self._json.to_json(self._store.codec(type_name), payload)

    async def response(self, type_name: str, payload: bytes) -> dict[str, Any] | JsonText:
        """Return the payload of a response for JSON, like `to_json`, without delaying other clients.

        Raises SerializationError.
        """
        if len(payload) <= _MAX_QUICK_BYTES:
            return self.to_json(type_name, payload)
        codec = self._store.codec(type_name)
        return JsonText(await asyncio.to_thread(self._json.text, codec, payload))

    def from_json(self, type_name: str, value: Any) -> bytes:
        """Return the payload of a JSON value. Raises SerializationError with the name of the field."""
        return self._json.from_json(self._store.codec(type_name), value, self._now())

    async def payload(self, type_name: str, value: Any, request: Request) -> bytes:
        """Return the payload of a JSON value of a request, like `from_json`, without delaying other clients.

        Raises SerializationError.
        """
        if request.value_count <= _FEW_VALUES:
            return self.from_json(type_name, value)
        return await asyncio.to_thread(self.from_json, type_name, value)

    async def published(self, topic: str, batch: Batch, index: int, compression: Compression) -> str | bytes:
        """Return the protocol's message with one message of a topic.

        Raises SerializationError, and the errors of `PublisherConnection.codec`.
        """
        key = (compression, topic, index)
        form: str | bytes | asyncio.Task[str | bytes] | None = batch.forms.get(key)
        if form is None:
            if len(batch.payloads[index]) <= _MAX_QUICK_BYTES or compression is Compression.CBOR_RAW:
                form = self._published(topic, batch, index, compression)
            else:
                convert = asyncio.to_thread(self._published, topic, batch, index, compression)
                form = asyncio.ensure_future(convert)
            batch.forms[key] = form
        if not isinstance(form, asyncio.Task):
            return form
        # Other clients may wait for the same conversion.
        await asyncio.wait([form])
        return form.result()

    def _published(self, topic: str, batch: Batch, index: int, compression: Compression) -> str | bytes:
        payload = batch.payloads[index]
        if compression is Compression.CBOR_RAW:
            from rostether.gateways.rosbridge.cbor import publish_raw

            if self._style is Style.ROS2:
                payload = self._ros2_types.message(batch.connection.type).converter.to_cdr(payload)
            return publish_raw(topic, payload, batch.forms.setdefault("received", self._now()))
        codec = batch.connection.codec
        if compression is Compression.CBOR:
            return self._cbor_form.publish(topic, codec, payload)
        text = batch.forms.get(index)
        if text is None:
            text = batch.forms[index] = self._json.text(codec, payload)
        whole = f'{{"op":"publish","topic":{json.dumps(topic)},"msg":{text}}}'
        return pack_png(whole) if compression is Compression.PNG else whole

    @cached_property
    def _cbor_form(self) -> CborForm:
        from rostether.gateways.rosbridge.cbor import CborForm

        return CborForm(self._style)

    @cached_property
    def _ros2_types(self) -> Ros2Types:
        from rostether.ros2.types.native_types import types_of

        return types_of(self._store.registry)
