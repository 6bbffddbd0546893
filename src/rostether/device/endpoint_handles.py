"""The topic handles of a device."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

from rostether.device.line import DeviceLine
from rostether.errors import SerializationError
from rostether.rostime import Time
from rostether.serde.codec import Codec
from rostether.serde.values import Message

Fields: TypeAlias = Message | Mapping[str, Any]
OnMessage: TypeAlias = Callable[[Message], None]

_LOG = logging.getLogger(__name__)


class Publisher:
    """Sends messages of one topic to the host; made by `Device.publisher`."""

    def __init__(
        self, topic: str, topic_id: int, codec: Codec, line: DeviceLine, now: Callable[[], Time]
    ) -> None:
        self.topic = topic
        self._now = now
        self._topic_id = topic_id
        self._codec = codec
        self._line = line

    @property
    def message_class(self) -> type[Message]:
        """The class of the topic's messages; filling one and sending it again costs least."""
        return self._codec.message_class

    def publish(self, message: Fields | object = None, /, **fields: Any) -> bool:
        """Send one message, given whole, by its fields, or as the value of its only field; False when no
        host listens or the line is full. A time may be "now" or seconds.

        Raises SerializationError naming a field that does not fit, LocalProtocolError beyond the buffer.
        """
        return self._line.publish(self._topic_id, [encode(self._codec, message, fields, self._now)])

    def publish_many(self, messages: Iterable[Fields]) -> bool:
        """Send several messages, all or none; cheaper than one by one. Raises as `publish`."""
        return self._line.publish(self._topic_id, [self._codec.encode(message) for message in messages])


class Subscriber:
    """Receives messages of one topic from the host; made by `Device.subscriber`."""

    def __init__(self, topic: str, codec: Codec, callback: OnMessage) -> None:
        self.topic = topic
        self.received_count = 0
        self._codec = codec
        self._callback = callback

    def receive(self, payloads: Iterable[bytes]) -> None:
        """Decode payloads and call the callback; payloads of another type are counted and dropped."""
        for payload in payloads:
            try:
                message = self._codec.decode(payload)
            except SerializationError as error:
                _LOG.debug("dropped a message on %s: %s", self.topic, error)
                continue
            self.received_count += 1
            try:
                self._callback(message)
            except Exception:  # noqa: BLE001 - the program's own code may raise anything
                _LOG.exception("the callback of %s failed", self.topic)


def encode(
    codec: Codec, message: object, fields: Mapping[str, Any], now: Callable[[], Time] | None = None
) -> bytes:
    """Encode a message given whole, by its fields, or as its only field. Raises SerializationError."""
    if message is None:
        return codec.encode(fields, now=now)
    if fields:
        raise SerializationError(
            f"{codec.type_name} is given both as a message and as fields; give one of them"
        )
    return codec.encode(codec.fields_of(message), now=now)
