"""What two ends of a ROS connection must agree on: a type's name, md5sum and full text."""

from __future__ import annotations

from dataclasses import dataclass

ANY_TYPE = "*"
ANY_MD5SUM = "*"


@dataclass(frozen=True, slots=True)
class MessageType:
    """A message type as connection headers carry it; `definition` is the full text with dependencies."""

    name: str
    md5sum: str
    definition: str = ""


@dataclass(frozen=True, slots=True)
class ServiceType:
    """A service type; `md5sum` covers both halves, each half has its own as well."""

    name: str
    md5sum: str
    request: MessageType
    response: MessageType


ANY_MESSAGE = MessageType(ANY_TYPE, ANY_MD5SUM)


def agree(left: str, right: str) -> bool:
    """Return whether two md5sums, or two type names, agree: `*` agrees with all."""
    return left == right or ANY_MD5SUM in (left, right)
