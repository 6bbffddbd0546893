"""Decodes messages of a recording into values, with the definitions in the recording."""

from __future__ import annotations

from rostether.msgdef.registry import Registry
from rostether.recording.recorded import Connection, RecordedMessage
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.values import Message


class Decoder:
    """Decodes messages; each definition has its own registry, because two may have the same name."""

    def __init__(self) -> None:
        self._codecs: dict[tuple[str, str, str], Codec] = {}

    def decode(self, message: RecordedMessage) -> Message:
        """Return the message's value. Raises SerializationError, DefinitionError."""
        return self.codec(message.connection).decode(message.payload)

    def codec(self, connection: Connection) -> Codec:
        """Return the codec of a connection's type. Raises DefinitionError."""
        message_type = connection.type
        key = (message_type.name, message_type.md5sum, message_type.definition)
        codec = self._codecs.get(key)
        if codec is None:
            text = message_type.definition
            registry = Registry.of_full_text(message_type.name, text) if text else Registry()
            codec = self._codecs[key] = TypeStore(registry).codec(message_type.name)
        return codec
