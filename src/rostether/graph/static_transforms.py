"""Merges the messages of a latched topic with transforms, such as /tf_static."""

from __future__ import annotations

import struct

# Even in a namespace.
STATIC_TOPIC = "/tf_static"

TRANSFORM_TYPES = frozenset({"tf2_msgs/TFMessage", "tf/tfMessage"})

# A robot has a few hundred transforms; a publisher that invents names must not fill memory.
MAX_FRAMES = 10_000

_COUNT = struct.Struct("<I")
# The sizes of the fields of geometry_msgs/TransformStamped before its two strings, and after them.
_BEFORE_BYTES = 12
_AFTER_BYTES = 56


class StaticTransforms:
    """All transforms of a topic so far, the latest one for each child frame.

    A latched topic keeps the last message of each publisher, so that a later subscriber receives all
    transforms. A relay or a board is one publisher, so its last message must have all transforms.
    """

    def __init__(self) -> None:
        self._transforms: dict[bytes, bytes] = {}

    def merge(self, payload: bytes) -> bytes:
        """Return the message with all transforms, unchanged if it has another layout or too many frames."""
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
