"""Connection headers: the `key=value` fields both ends of a TCPROS connection exchange first.

    uint32 length of everything below | uint32 length of a field, `key=value` | ...     (little endian)

Source: https://wiki.ros.org/ROS/Connection%20Header
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

from rostether.errors import RemoteProtocolError

MAX_HEADER_BYTES = 1 << 20
"""A header is mostly its message_definition: the longest of Debian's message packages have 20 kB."""

_LENGTH = struct.Struct("<I")


def encode_header(fields: Mapping[str, str]) -> bytes:
    """Return the fields as they stand on the wire, length first and sorted by key as rospy sorts them."""
    parts: list[bytes] = []
    for key, value in sorted(fields.items()):
        field = f"{key}={value}".encode("utf-8", "surrogateescape")
        parts += _LENGTH.pack(len(field)), field
    body = b"".join(parts)
    return _LENGTH.pack(len(body)) + body


def decode_fields(body: bytes) -> dict[str, str]:
    """Return the fields of a header without its leading length. Raises RemoteProtocolError."""
    fields: dict[str, str] = {}
    position, end = 0, len(body)
    while position < end:
        if end - position < 4:
            raise RemoteProtocolError("connection header ends inside a field's length")
        (length,) = _LENGTH.unpack_from(body, position)
        position += 4
        if length > end - position:
            raise RemoteProtocolError(
                f"connection header field claims {length} bytes, only {end - position} are left"
            )
        key, equals, value = (
            body[position : position + length].decode("utf-8", "surrogateescape").partition("=")
        )
        if not equals:
            raise RemoteProtocolError(f"connection header field {key[:80]!r} has no '='")
        fields[key.strip()] = value
        position += length
    return fields


class HeaderDecoder:
    """Collects one connection header from chunks cut anywhere; what follows it is `rest`."""

    def __init__(self, max_header_bytes: int = MAX_HEADER_BYTES) -> None:
        self._max_header_bytes = max_header_bytes
        self._buffer = bytearray()
        self.rest = b""

    def feed(self, data: bytes) -> dict[str, str] | None:
        """Take a chunk; return the fields once the header is complete.

        Raises RemoteProtocolError for a header longer than the limit or broken fields.
        """
        self._buffer += data
        if len(self._buffer) < 4:
            return None
        (length,) = _LENGTH.unpack_from(self._buffer)
        if length > self._max_header_bytes:
            raise RemoteProtocolError(
                f"connection header claims {length} bytes, more than {self._max_header_bytes}: "
                "not a TCPROS peer?"
            )
        if len(self._buffer) < 4 + length:
            return None
        self.rest = bytes(self._buffer[4 + length :])
        return decode_fields(bytes(self._buffer[4 : 4 + length]))
