"""The two versions of the rosserial frame, and their encoding.

Version 2 (Hydro and later), 8 bytes around the payload:

    +------+------+-----+-----+------+-------+-------+= = = = = = = =+------+
    | 0xff | 0xfe | N low high| c(N) | id low   high | payload, N    | c(id, payload)
    +------+------+-----+-----+------+-------+-------+= = = = = = = =+------+

Version 1 (Groovy and earlier), 7 bytes around the payload, no check before its end:

    +------+------+-------+-------+-----+-----+= = = = = = = =+------+
    | 0xff | 0xff | id low   high | N low high| payload, N    | c(id, N, payload)
    +------+------+-------+-------+-----+-----+= = = = = = = =+------+

c(...) is 255 minus the sum of the bytes in the brackets, modulo 256. Numbers are unsigned and little endian.
N may be 0.

Source: the protocol page http://wiki.ros.org/rosserial/Overview/Protocol, and the established host.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

from rostether.errors import LocalProtocolError
from rostether.rosserial.checksum import one_plus_sum
from rostether.rosserial.topic_id import LAST_ID

SYNC = 0xFF
# The maximum of the length field. Real boards stay below 1 kB; Linux devices send images in one frame.
MAX_PAYLOAD_BYTES = 0xFFFF

_BYTES = tuple(bytes((value,)) for value in range(256))
_V1_HEAD = struct.Struct("<BBHH")
_V2_HEAD = struct.Struct("<BBHBH")


class FrameForm(NamedTuple):
    """The differences between the versions: the second byte, and the sizes of header and checksum."""

    version_byte: int
    header_bytes: int
    overhead_bytes: int


FORMS = {1: FrameForm(0xFF, 6, 7), 2: FrameForm(0xFE, 7, 8)}


class Header(NamedTuple):
    """The content of a frame header.

    The sum of `base`, the payload's bytes and the checksum is 255 modulo 256.
    """

    topic_id: int
    size: int
    base: int


def read_header(version: int, header: bytes) -> Header | None:
    """Read the `header_bytes` of a frame that begins with the right sync; None if its own check fails."""
    if version == 1:
        _, _, topic_id, size = _V1_HEAD.unpack(header)
        return Header(topic_id, size, sum(header[2:]) & 0xFF)
    _, _, size, check, topic_id = _V2_HEAD.unpack(header)
    if (header[2] + header[3] + check) & 0xFF != 0xFF:
        return None
    return Header(topic_id, size, (header[5] + header[6]) & 0xFF)


@lru_cache(maxsize=4096)  # a few dozen topics times the lengths of their strings
def _head(version: int, topic_id: int, size: int) -> tuple[bytes, int]:
    """Return the header, and the number to add to 1 + the payload's sum for the checksum's complement."""
    if not 0 <= topic_id <= LAST_ID:
        raise LocalProtocolError(f"topic id {topic_id} does not fit in two bytes; use 0 to {LAST_ID}")
    if size > MAX_PAYLOAD_BYTES:
        raise LocalProtocolError(
            f"a payload of {size} bytes does not fit in a frame; send at most {MAX_PAYLOAD_BYTES} bytes"
        )
    if version == 1:
        head = _V1_HEAD.pack(SYNC, 0xFF, topic_id, size)
        return head, sum(head[2:]) - 1
    if version == 2:
        length_check = 255 - ((size & 0xFF) + (size >> 8)) % 256
        head = _V2_HEAD.pack(SYNC, 0xFE, size, length_check, topic_id)
        return head, head[5] + head[6] - 1
    raise LocalProtocolError(f"unknown protocol version {version}; use 1 or 2")


def encode_frame(topic_id: int, payload: bytes, version: int = 2) -> bytes:
    """Return one frame. Raises LocalProtocolError if the content does not fit."""
    head, base = _head(version, topic_id, len(payload))
    return head + payload + _BYTES[255 - ((one_plus_sum(payload) + base) & 0xFF)]


def encode_frames(topic_id: int, payloads: Iterable[bytes], version: int = 2) -> bytes:
    """Return the frames of several payloads, joined. Raises the same errors as encode_frame."""
    parts: list[bytes] = []
    for payload in payloads:
        head, base = _head(version, topic_id, len(payload))
        parts += (head, payload, _BYTES[255 - ((one_plus_sum(payload) + base) & 0xFF)])
    return b"".join(parts)
