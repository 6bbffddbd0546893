"""Converts messages to the forms of clients, once for all clients with the same form."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from rostether.gateways.rosbridge.client_subscription import Compression
from rostether.gateways.rosbridge.png_packing import pack_png
from rostether.gateways.rosbridge.values import JsonForm, Style
from rostether.gateways.shared_subscriptions import Batch
from rostether.rostime import Time
from rostether.serde.store import TypeStore

if TYPE_CHECKING:
    from rostether.gateways.rosbridge.cbor import CborForm
    from rostether.gateways.rosbridge.cdr_form import CdrForm
    from rostether.gateways.rosbridge.request import Request

# The smallest messages, such as transforms, take 10 µs each.
_FEW_VALUES: Final = 2048


class MessageForms:
    """Converts between payloads and the protocol's messages; `now` is the graph's time."""

    def __init__(self, store: TypeStore, style: Style, now: Callable[[], Time]) -> None:
        self._store = store
        self._style = style
        self._json = JsonForm(style)
        self._cbor: CborForm | None = None
        self._cdr: CdrForm | None = None
        self._now = now

    def to_json(self, type_name: str, payload: bytes) -> dict[str, Any]:
        """Return a payload of a known type as a JSON value. Raises SerializationError."""
        return self._json.to_json(self._store.codec(type_name), payload)

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

    def published(self, topic: str, batch: Batch, index: int, compression: Compression) -> str | bytes:
        """Return the protocol's message with one message of a topic.

        Raises SerializationError, and the errors of `PublisherConnection.codec`.
        """
        key = (compression, topic, index)
        frame: str | bytes | None = batch.forms.get(key)
        if frame is None:
            frame = batch.forms[key] = self._published(topic, batch, index, compression)
        return frame

    def _published(self, topic: str, batch: Batch, index: int, compression: Compression) -> str | bytes:
        payload = batch.payloads[index]
        if compression is Compression.CBOR_RAW:
            from rostether.gateways.rosbridge.cbor import publish_raw

            if self._style is Style.ROS2:
                payload = self._cdr_form().to_cdr(batch.connection.type, payload)
            return publish_raw(topic, payload, batch.forms.setdefault("received", self._now()))
        codec = batch.connection.codec
        if compression is Compression.CBOR:
            return self._cbor_form().publish(topic, codec, payload)
        text = batch.forms.get(index)
        if text is None:
            text = batch.forms[index] = self._json.text(codec, payload)
        whole = f'{{"op":"publish","topic":{json.dumps(topic)},"msg":{text}}}'
        return pack_png(whole) if compression is Compression.PNG else whole

    def _cbor_form(self) -> CborForm:
        if self._cbor is None:
            from rostether.gateways.rosbridge.cbor import CborForm

            self._cbor = CborForm(self._style)
        return self._cbor

    def _cdr_form(self) -> CdrForm:
        if self._cdr is None:
            from rostether.gateways.rosbridge.cdr_form import CdrForm

            self._cdr = CdrForm(self._store.registry)
        return self._cdr
