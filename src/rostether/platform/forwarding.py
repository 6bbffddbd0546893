"""The payload of a frame with the flag FORWARD: where to send a query, and the query.

    bytes   field
    0-15    address of the other robot: IPv6, or IPv4 as an IPv6 address (::ffff:a.b.c.d)
    16-17   its port, big-endian
    18-     the query, a framed command under the same key

A forwarded query shows whether two robots reach each other, which an access point may prevent.
"""

from __future__ import annotations

import ipaddress
import struct

from rostether.errors import RemoteProtocolError
from rostether.platform.command_frame import Flags, decode_frame

_TARGET = struct.Struct("!16sH")


def encode_forward(address: str, port: int, query: bytes) -> bytes:
    """Return the payload. Raises ValueError for an address that is not numeric."""
    parsed = ipaddress.ip_address(address)
    mapped = parsed if parsed.version == 6 else ipaddress.IPv6Address(f"::ffff:{parsed}")
    return _TARGET.pack(mapped.packed, port) + query


def decode_forward(payload: bytes, key: bytes) -> tuple[str, int, bytes]:
    """Return address, port and query. Raises RemoteProtocolError for anything that is not a query."""
    if len(payload) < _TARGET.size:
        raise RemoteProtocolError(f"{len(payload)} bytes are not an address and a query to forward")
    packed, port = _TARGET.unpack_from(payload)
    query = payload[_TARGET.size :]
    # A robot sends nothing else for others: no command, and no bytes of their choice.
    if decode_frame(query, key).flags & ~Flags.TO_GROUPS != Flags.QUERY:
        raise RemoteProtocolError("only queries are forwarded")
    parsed = ipaddress.IPv6Address(packed)
    return str(parsed.ipv4_mapped or parsed), port, query
