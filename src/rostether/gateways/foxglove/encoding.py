"""Converts the messages of Foxglove clients to ROS messages; slow conversions run in a thread."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from typing import Final

from msgspec import Struct

from rostether.errors import SerializationError
from rostether.gateways.foxglove.json_messages import decode_json
from rostether.serde.codec import Codec
from rostether.serde.layout import Layout

# Longer messages may take longer than 10 ms. In JSON, each `{}` can be a message with default values.
MAX_QUICK_JSON_BYTES: Final = 1 << 10

# The check of each string in a list takes 0.3 µs, and an empty string has only 4 bytes.
_MAX_QUICK_ROS1_BYTES: Final = 32 << 10

# Types with more default values are slow in any JSON message.
_MANY_DEFAULTS: Final = 1000


class Encoder(Struct, frozen=True):
    """Converts a client's message to a ROS message. `encode` raises SerializationError."""

    encode: Callable[[bytes], bytes]
    max_quick_bytes: int

    @classmethod
    def of_json(cls, codec: Codec) -> Encoder:
        """Return the encoder of JSON messages of a type."""
        is_small = codec.tree.zero_elements <= _MANY_DEFAULTS
        return cls(
            lambda payload: codec.encode(decode_json(codec, payload)), MAX_QUICK_JSON_BYTES if is_small else 0
        )

    @classmethod
    def of_ros1(cls, layout: Layout) -> Encoder:
        """Return the encoder of ROS 1 messages, which only checks them."""

        def check(payload: bytes) -> bytes:
            if not layout.accepts(payload):
                raise SerializationError(layout.explain(payload))
            return payload

        return cls(check, _MAX_QUICK_ROS1_BYTES if layout.has_varying_elements else sys.maxsize)

    def is_slow(self, payload: bytes) -> bool:
        """Return whether a message may take longer than 10 ms."""
        return len(payload) > self.max_quick_bytes

    async def convert(self, payload: bytes) -> bytes:
        """Return the ROS message, without delaying other clients. Raises SerializationError."""
        if self.is_slow(payload):
            return await asyncio.to_thread(self.encode, payload)
        return self.encode(payload)
