"""Identifies a type on a ROS connection: its name, md5sum and full text."""

from __future__ import annotations

from msgspec import Struct

ANY_TYPE = "*"
ANY_MD5SUM = "*"


class MessageType(Struct, frozen=True):
    """A message type of a connection header; `definition` is the full text with dependencies."""

    name: str
    md5sum: str
    definition: str = ""


class ServiceType(Struct, frozen=True):
    """A service type; `md5sum` is of request and response together, and each also has its own."""

    name: str
    md5sum: str
    request: MessageType
    response: MessageType


ANY_MESSAGE = MessageType(ANY_TYPE, ANY_MD5SUM)


def agree(left: str, right: str) -> bool:
    """Return whether two md5sums, or two type names, agree: `*` agrees with all."""
    return left == right or ANY_MD5SUM in (left, right)
