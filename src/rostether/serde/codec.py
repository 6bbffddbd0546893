"""Values to bytes and back, for one message type."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rostether.errors import SerializationError
from rostether.rostime import Time
from rostether.serde.conform import Conformer
from rostether.serde.decoder_source import DECODE_ERRORS, Decode, compile_decoder
from rostether.serde.encoder_source import ENCODE_ERRORS, Encode, compile_encoder
from rostether.serde.layout import Layout
from rostether.serde.type_tree import Struct
from rostether.serde.values import Message, MessageClasses


class Codec:
    """Encodes and decodes one message type; compiled on first use of each direction."""

    def __init__(self, tree: Struct, classes: MessageClasses, layout: Layout) -> None:
        self.tree = tree
        self.layout = layout
        self.message_class = classes.of(tree)
        self._classes = classes
        self._encode: Encode = self._first_encode
        self._decode: Decode = self._first_decode

    @property
    def type_name(self) -> str:
        """The type as `package/Name`."""
        return self.tree.name

    def class_of(self, tree: Struct) -> type[Message]:
        """Return the class of a message type at or below this one."""
        return self._classes.of(tree)

    def encode(self, value: Message | Mapping[str, Any], *, now: Callable[[], Time] | None = None) -> bytes:
        """Return the ROS 1 serialization. Raises SerializationError naming the field that does not fit.

        Messages may have mappings, tuples or numpy arrays instead of messages and lists. With `now`,
        which returns the time, a time may be the word `now` or a number of seconds.
        """
        if isinstance(value, Message) and value._type == self.tree.name:
            try:
                return self._encode(value)
            except ENCODE_ERRORS:
                pass
        message = Conformer(self.tree, self._classes, now).message(value)
        try:
            return self._encode(message)
        except ENCODE_ERRORS as error:  # pragma: no cover - `conform` refuses nearly all
            raise SerializationError(f"{self.tree.name} cannot be encoded: {error}") from error

    def encode_given(
        self, message: object, fields: Mapping[str, Any], *, now: Callable[[], Time] | None = None
    ) -> bytes:
        """Encode a message, its fields, or its only field's value.

        Raises SerializationError as `encode` does, and if both a message and fields are given.
        """
        if message is None:
            return self.encode(fields, now=now)
        if fields:
            raise SerializationError(
                f"{self.type_name} is given both as a message and as fields; give one of them"
            )
        return self.encode(self._fields_of(message), now=now)

    def decode(self, payload: bytes) -> Message:
        """Return the message in a payload. Raises SerializationError with the difference."""
        try:
            return self._decode(payload)
        except DECODE_ERRORS:
            raise SerializationError(self.layout.explain(payload)) from None

    def conform(self, value: Message | Mapping[str, Any]) -> Message:
        """Return a complete message, each value in its own Python type. Raises SerializationError."""
        return Conformer(self.tree, self._classes).message(value)

    def _fields_of(self, value: object) -> Message | Mapping[str, Any]:
        """Return a message or its fields; any other value is that of the only field.

        Raises SerializationError for a type with several fields.
        """
        if isinstance(value, Message | Mapping):
            return value
        names = [member.name for member in self.tree.members]
        if len(names) != 1:
            raise SerializationError(
                f"{self.tree.name} has {len(names)} fields ({', '.join(names)}), so give values by name"
            )
        return {names[0]: value}

    def _first_encode(self, message: Message) -> bytes:
        self._encode = compile_encoder(self.tree, self._classes)
        return self._encode(message)

    def _first_decode(self, payload: bytes) -> Message:
        self._decode = compile_decoder(self.tree, self._classes)
        return self._decode(payload)
