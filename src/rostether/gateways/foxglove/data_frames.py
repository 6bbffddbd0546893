"""Messages of a topic as WebSocket frames, built by hand: this is what a gateway does most.

    0x82 | length (1, 3 or 9 bytes) | 0x01 | subscription id u32 | log time u64 ns | payload

The WebSocket's length is big endian (RFC 6455), the rest little endian. A server's frames are not masked.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

_BINARY = 0x82  # the whole message in one frame
_MESSAGE_DATA = 0x01
_HEADER_BYTES = 13
_SHORT = struct.Struct("<BBBIQ")
_MEDIUM = struct.Struct("<BB2sBIQ")
_LONG = struct.Struct("<BB8sBIQ")


def add_data_frames(
    pieces: list[bytes], subscription_id: int, time_ns: int, payloads: Sequence[bytes]
) -> int:
    """Append the frames of payloads to a list of pieces to write; returns their size."""
    size = 0
    for payload in payloads:
        length = len(payload) + _HEADER_BYTES
        if length < 126:
            header = _SHORT.pack(_BINARY, length, _MESSAGE_DATA, subscription_id, time_ns)
        elif length < 65536:
            header = _MEDIUM.pack(
                _BINARY, 126, length.to_bytes(2, "big"), _MESSAGE_DATA, subscription_id, time_ns
            )
        else:
            header = _LONG.pack(
                _BINARY, 127, length.to_bytes(8, "big"), _MESSAGE_DATA, subscription_id, time_ns
            )
        pieces.append(header)
        pieces.append(payload)
        size += len(header) + len(payload)
    return size
