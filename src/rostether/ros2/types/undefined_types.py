"""Types for tools that do not need fields: messages of a type without a definition remain in CDR."""

from __future__ import annotations

from typing import cast

from rostether.errors import UnknownTypeError
from rostether.msgdef.interface import ANY_MD5SUM, MessageType
from rostether.ros2.types.native_registry import NativeRegistry, short_name
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import ANY_HASH, MessageSupport
from rostether.serde.cdr.converter import CdrConverter


class UndefinedTypes(NativeTypes):
    """Types by name; payloads of types without a definition are CDR.

    An unknown type has only a name and the hash of its publisher, but no md5sum and no text.
    """

    def __init__(self, registry: NativeRegistry, *, asks_nodes: bool = True) -> None:
        super().__init__(registry)
        self.asks_nodes = asks_nodes
        self._undefined: dict[str, MessageSupport] = {}

    def received(self, name: str, type_hash: str) -> MessageSupport:
        """Return a message type's support; payloads remain CDR if no definition has the publisher's hash."""
        try:
            support = self.by_name(name)
        except UnknownTypeError:
            pass
        else:
            if support.type_hash in (type_hash, ANY_HASH) or not type_hash.startswith("RIHS"):
                return support
        message_type = MessageType(short_name(name), ANY_MD5SUM)
        support = MessageSupport(name, type_hash, message_type, cast("CdrConverter", _Unchanged()))
        self._undefined[message_type.name] = support
        return support

    def message(self, message_type: MessageType) -> MessageSupport:
        """Return a message type's support in ROS 2. Raises the same errors as `Ros2Types.message`."""
        if message_type.md5sum == ANY_MD5SUM and message_type.name in self._undefined:
            return self._undefined[message_type.name]
        return super().message(message_type)

    def full_text(self, message_type: MessageType) -> str:
        """Return the ROS 2 text of a message type; empty without a definition."""
        return "" if message_type.md5sum == ANY_MD5SUM else super().full_text(message_type)


class _Unchanged:
    """Returns CDR unchanged."""

    def from_cdr(self, cdr: bytes) -> bytes:
        return cdr

    def to_cdr(self, payload: bytes) -> bytes:
        return payload
