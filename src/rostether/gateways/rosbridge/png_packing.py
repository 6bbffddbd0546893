"""Texts in PNG images: rosbridge's oldest compression, with the image in base64.

The bytes of the text are the pixels of an approximately square image with three bytes per pixel; the rest is
filled with newlines (source: rosbridge_suite's protocol and behavior). Received images may be gray, color or
with alpha; all PNG row filters are supported.
"""

from __future__ import annotations

import math
import struct
import zlib
from binascii import Error as Base64Error
from binascii import a2b_base64, b2a_base64
from typing import Final

from rostether.errors import RemoteProtocolError

_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"

# Bytes per pixel by color type: gray, color, each without and with alpha.
_BYTES_PER_PIXEL: Final = {0: 1, 2: 3, 4: 2, 6: 4}
_COLOR: Final = 2

# Row filters are undone byte by byte, which takes 0.1 s for this size; packed texts need no row filters.
_MAX_FILTERED_BYTES: Final = 1 << 18

# Three times as fast as the default 6, and 10 % larger: boards wait while an image is packed.
_LEVEL: Final = 1


def pack_png(text: str) -> str:
    """Return the `png` message that contains a text."""
    content = text.encode("utf-8", "replace")
    width = max(1, math.isqrt(len(content) // 3))
    height = max(1, math.ceil(len(content) / 3 / width))
    row = width * 3
    padded = content.ljust(row * height, b"\n")
    # Each row starts with its filter type, 0 for none.
    rows = b"".join(b"\0" + padded[at : at + row] for at in range(0, len(padded), row))
    picture = (
        _SIGNATURE
        + _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, _COLOR, 0, 0, 0))
        + _chunk(b"IDAT", zlib.compress(rows, _LEVEL))
        + _chunk(b"IEND", b"")
    )
    return f'{{"op":"png","data":"{b2a_base64(picture, newline=False).decode("ascii")}"}}'


def unpack_png(data: str, max_bytes: int) -> str:
    """Return the text in a `png` message's data, of `max_bytes` at most. Raises RemoteProtocolError."""
    try:
        return _text(a2b_base64(data), max_bytes)
    except (Base64Error, ValueError, struct.error, zlib.error) as error:
        raise RemoteProtocolError(f"png: this image does not contain a packed text: {error}") from None


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _text(picture: bytes, max_bytes: int) -> str:
    if not picture.startswith(_SIGNATURE):
        raise ValueError("it is not a PNG file")
    header = b""
    packed = []
    at = len(_SIGNATURE)
    while at < len(picture):
        length, kind = struct.unpack_from(">I4s", picture, at)
        content = picture[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            header = content
        elif kind == b"IDAT":
            packed.append(content)
        at += length + 12
    width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", header)
    if depth != 8 or color not in _BYTES_PER_PIXEL or interlace:
        raise ValueError(
            "only images with 8 bits per channel, without palette and interlacing, are supported"
        )
    pixel = _BYTES_PER_PIXEL[color]
    row = width * pixel
    size = (row + 1) * height
    if not 0 < row * height <= max_bytes:
        raise ValueError(f"it contains {row * height} bytes; 1 to {max_bytes} are allowed")
    rows = zlib.decompressobj().decompress(b"".join(packed), size)
    if len(rows) < size:
        raise ValueError("it ends early")
    return _unfiltered(rows, row, pixel).decode("utf-8").rstrip("\n\0")


def _unfiltered(rows: bytes, size: int, pixel: int) -> bytes:
    """Return the bytes of all rows without their filters. Raises ValueError."""
    if len(rows) > _MAX_FILTERED_BYTES:
        filtered = sum(kind != 0 for kind in rows[:: size + 1]) * size
        if filtered > _MAX_FILTERED_BYTES:
            raise ValueError(
                f"{filtered} of its bytes have row filters; at most {_MAX_FILTERED_BYTES} are allowed"
            )
    content = bytearray()
    above = bytes(size)
    for at in range(0, len(rows), size + 1):
        row = bytearray(rows[at + 1 : at + 1 + size])
        _undo(rows[at], row, above, pixel)
        content += row
        above = bytes(row)
    return bytes(content)


def _undo(kind: int, row: bytearray, above: bytes, pixel: int) -> None:
    """Undo a row's filter in place (source: PNG specification, section 9)."""
    if kind == 0:
        return
    for index in range(len(row)):
        left = row[index - pixel] if index >= pixel else 0
        up = above[index]
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        elif kind == 4:
            guess = _paeth(left, up, above[index - pixel] if index >= pixel else 0)
        else:
            raise ValueError(f"unknown row filter {kind}")
        row[index] = (row[index] + guess) & 0xFF


def _paeth(left: int, up: int, corner: int) -> int:
    """Return the neighbor that is nearest to left + up - corner."""
    near_left, near_up, near_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if near_left <= near_up and near_left <= near_corner:
        return left
    return up if near_up <= near_corner else corner
