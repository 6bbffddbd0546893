"""The exceptions of bags, and the classes of their messages: those of this process, or of the bag."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rostether.errors import RostetherError
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.recording.recorded import Connection
from rostether.rospy.client.message import Message
from rostether.rospy.client.message_types import MessageTypes, all_types


def header_of(connection: Connection) -> dict[str, bytes]:
    """Return the header of a connection; as in rosbag, its values are bytes."""
    return {key: value.encode("utf-8", "surrogateescape") for key, value in connection.fields().items()}


def with_header(topic: str, kind: MessageType, header: Mapping[str, str | bytes]) -> Connection:
    """Return the connection of a topic with the header fields of a script."""
    given = {
        str(name): value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else str(value)
        for name, value in header.items()
    }
    known = {"type": kind.name, "md5sum": kind.md5sum, "message_definition": kind.definition}
    return Connection.from_fields(topic, given | known)


def raw_parts(message: Any) -> tuple[MessageType, bytes]:
    """Return the type and bytes of a raw message, as `read_messages(raw=True)` yields it.

    Raises ROSBagException.
    """
    name, payload, md5sum = message[:3]
    made = message[-1] if len(message) > 3 else None
    if isinstance(made, type) and issubclass(made, Message):
        return MessageType(name, md5sum, made._full_text), payload
    try:
        known = all_types().registry.message_type(name)
    except RostetherError as error:
        raise ROSBagException(str(error)) from None
    if md5sum not in (known.md5sum, "*"):
        raise ROSBagException(f"{name} has md5sum {known.md5sum} here, not {md5sum}; also give its class")
    return known, payload


def class_of(kind: MessageType) -> type[Message]:
    """Return the class of this process if its type is the same, else a class of the recorded definition.

    Raises ROSBagException if the type cannot be read.
    """
    try:
        return _class_of(kind)
    except RostetherError as error:
        raise ROSBagException(f"{kind.name} cannot be read: {error}") from None


def _class_of(kind: MessageType) -> type[Message]:
    try:
        own = all_types().message_class(kind.name)
    except RostetherError:
        if not kind.definition:
            raise
    else:
        if own._md5sum == kind.md5sum or not kind.definition:
            return own
    return MessageTypes(Registry.of_full_text(kind.name, kind.definition)).message_class(kind.name)


class ROSBagException(Exception):
    """The base of rosbag's errors."""

    def __init__(self, value: str | None = None) -> None:
        self.value = value
        super().__init__(value)

    def __str__(self) -> str:
        return str(self.value)


class ROSBagFormatException(ROSBagException):
    """The file is not a bag, or is damaged."""


class ROSBagUnindexedException(ROSBagException):
    """The bag was not closed."""

    def __init__(self, *args: Any) -> None:
        super().__init__("Unindexed bag")
