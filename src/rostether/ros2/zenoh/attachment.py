"""The 33 bytes that rmw_zenoh attaches to every sample: i64 sequence, i64 ns since the epoch, u8 16, GID[16].

All numbers are little-endian; 16 is the size of the GID. rmw_zenoh drops samples without these bytes. In a
service call, the reply repeats the sequence and the GID of the request, which identify the request.

Source: the design document of rmw_zenoh.
"""

from __future__ import annotations

import struct

import msgspec
import xxhash

GID_BYTES = 16
ATTACHMENT = struct.Struct(f"<qqB{GID_BYTES}s")


class Attachment(msgspec.Struct, frozen=True):
    """The sequence number, time and sender of one sample."""

    sequence: int
    stamp_ns: int
    gid: bytes

    def encode(self) -> bytes:
        """Return the attachment's bytes."""
        return ATTACHMENT.pack(self.sequence, self.stamp_ns, GID_BYTES, self.gid)


def parse_attachment(data: bytes) -> Attachment | None:
    """Read a peer's attachment; None if it is not from rmw_zenoh."""
    if len(data) < ATTACHMENT.size:
        return None
    sequence, stamp_ns, size, gid = ATTACHMENT.unpack_from(data)
    return Attachment(sequence, stamp_ns, gid) if size == GID_BYTES else None


def gid_of(token: str) -> bytes:
    """Return the GID of the endpoint that has this liveliness token: XXH3-128, low half first."""
    return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(GID_BYTES, "little")
