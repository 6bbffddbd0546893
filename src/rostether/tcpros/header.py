"""Connection headers: the `key=value` fields at the start of a TCPROS connection.

    uint32 length of everything below | uint32 length of a field, `key=value` | ...     (little endian)

Source: https://wiki.ros.org/ROS/Connection%20Header
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

from rostether.errors import RemoteProtocolError

# A header is mostly its message_definition: the longest in Debian's message packages is 20 KB.
MAX_HEADER_BYTES = 1 << 20

# The headers in use have at most ten fields.
MAX_FIELDS = 64

# The longest key in use has 18 bytes.
MAX_KEY_BYTES = 256

# Names, types and errors; only a message_definition may be longer.
MAX_VALUE_BYTES = 16 << 10

_LENGTH = struct.Struct("<I")


def encode_header(fields: Mapping[str, str]) -> bytes:
    """Return the encoded fields, length first, sorted by key as in rospy."""
    parts: list[bytes] = []
    for key, value in sorted(fields.items()):
        field = f"{key}={value}".encode("utf-8", "surrogateescape")
        parts += _LENGTH.pack(len(field)), field
    body = b"".join(parts)
    return _LENGTH.pack(len(body)) + body


def decode_fields(body: bytes) -> dict[str, str]:
    """Return the fields of a header without its leading length. Raises RemoteProtocolError."""
    fields: dict[str, str] = {}
    position, end, count = 0, len(body), 0
    while position < end:
        if end - position < 4:
            raise RemoteProtocolError("the connection header ends inside a field's length")
        (length,) = _LENGTH.unpack_from(body, position)
        position += 4
        count += 1
        if count > MAX_FIELDS:
            raise RemoteProtocolError(f"the connection header has more than {MAX_FIELDS} fields")
        if length > end - position:
            raise RemoteProtocolError(
                f"a connection header field claims {length} bytes, but only {end - position} are left"
            )
        following = position + length
        equals = body.find(b"=", position, min(following, position + MAX_KEY_BYTES))
        if equals < 0:
            start = body[position : min(following, position + 80)].decode("utf-8", "replace")
            raise RemoteProtocolError(f"the connection header field {start!r} has no '='")
        key = body[position:equals].decode("utf-8", "surrogateescape").strip()
        if following - equals > MAX_VALUE_BYTES and key != "message_definition":
            raise RemoteProtocolError(
                f"the connection header field {key!r} is longer than {MAX_VALUE_BYTES} bytes"
            )
        fields[key] = body[equals + 1 : following].decode("utf-8", "surrogateescape")
        position = following
    return fields


class HeaderDecoder:
    """Collects one connection header from chunks, which may end anywhere; `rest` are the bytes after it."""

    def __init__(self, max_header_bytes: int = MAX_HEADER_BYTES) -> None:
        self._max_header_bytes = max_header_bytes
        self._buffer = bytearray()
        self.rest = b""

    @property
    def held_bytes(self) -> int:
        """The number of kept bytes of an incomplete header."""
        return len(self._buffer)

    def feed(self, data: bytes) -> dict[str, str] | None:
        """Handle a chunk; return the fields once the header is complete.

        Raises RemoteProtocolError for a header longer than the limit or broken fields.
        """
        self._buffer += data
        if len(self._buffer) < 4:
            return None
        (length,) = _LENGTH.unpack_from(self._buffer)
        if length > self._max_header_bytes:
            raise RemoteProtocolError(
                f"the connection header claims {length} bytes, more than {self._max_header_bytes}: "
                "not a TCPROS peer?"
            )
        if len(self._buffer) < 4 + length:
            return None
        self.rest = bytes(self._buffer[4 + length :])
        body = bytes(self._buffer[4 : 4 + length])
        self._buffer.clear()
        return decode_fields(body)
