"""Merges the static transforms of several publishers, because a relay is one publisher.

A latched topic has one last message for each publisher: a subscriber that comes later receives the transforms
of all. A relay has one last message for all of them, so this message must have all transforms.
"""

from __future__ import annotations

import struct
from typing import Final

TYPES: Final = frozenset({"tf2_msgs/TFMessage", "tf/tfMessage"})

# A robot has a few hundred; a publisher that invents names must not fill memory.
MAX_FRAMES: Final = 10_000

_COUNT = struct.Struct("<I")
# The fields of a TransformStamped before its two strings, and after them.
_BEFORE_BYTES = 12
_AFTER_BYTES = 56


class StaticTransforms:
    """All transforms of a topic so far, the latest one for each child frame."""

    def __init__(self) -> None:
        self._transforms: dict[bytes, bytes] = {}

    def merge(self, payload: bytes) -> bytes:
        """Return the message with all transforms; a message that has another layout stays as it is."""
        try:
            found = _read(payload)
        except struct.error:
            return payload
        if len(self._transforms | found) > MAX_FRAMES:
            return payload
        self._transforms |= found
        return _COUNT.pack(len(self._transforms)) + b"".join(self._transforms.values())


def _read(payload: bytes) -> dict[bytes, bytes]:
    """Return the transforms by child frame. Raises struct.error."""
    (count,) = _COUNT.unpack_from(payload)
    position, found = _COUNT.size, {}
    for _ in range(count):
        start = position
        _, position = _text(payload, start + _BEFORE_BYTES)
        child, position = _text(payload, position)
        position += _AFTER_BYTES
        if position > len(payload):
            raise struct.error("the message is too short")
        found[child] = payload[start:position]
    return found


def _text(payload: bytes, position: int) -> tuple[bytes, int]:
    (length,) = _COUNT.unpack_from(payload, position)
    start = position + _COUNT.size
    return payload[start : start + length], start + length
