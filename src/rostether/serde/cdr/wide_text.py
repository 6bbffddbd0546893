"""wstring: UTF-16 in ROS 2, in CDR four bytes for each unit without an end mark; a UTF-8 string in ROS 1.

Fast CDR writes it so, checked with rclpy's `test_msgs/msg/WStrings`.
"""

from __future__ import annotations

import struct

UNIT_BYTES = 4


def widen(text: bytes) -> bytes:
    """Return the units of a UTF-8 text, as CDR has them behind their count."""
    encoded = text.decode("utf-8", "replace").encode("utf-16-le")
    count = len(encoded) // 2
    return struct.pack(f"<{count}I", *struct.unpack(f"<{count}H", encoded))


def narrow(units: bytes) -> bytes:
    """Return units of CDR as a UTF-8 text. Raises struct.error if one has more than 16 bits."""
    count = len(units) // UNIT_BYTES
    encoded = struct.pack(f"<{count}H", *struct.unpack_from(f"<{count}I", units))
    return encoded.decode("utf-16-le", "replace").encode()
