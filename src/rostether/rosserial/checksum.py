"""The one-byte sums of rosserial frames, at the speed of zlib.

Adler-32 keeps 1 + the sum of all bytes, modulo 65521, in its low 16 bits. Up to 256 bytes the modulus is
never reached (1 + 256 * 255 < 65521), so `adler32(piece) & 0xffff` is 1 + the exact sum of the piece, in one
C call. Longer payloads are summed piece by piece.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import accumulate
from struct import Struct
from zlib import adler32

PIECE_BYTES = 256
_PAIR_BYTES = 2 * PIECE_BYTES


def one_plus_sum(data: bytes) -> int:
    """Return a number with the same low byte as 1 + the sum of all bytes; `data` may have any length."""
    size = len(data)
    if size <= PIECE_BYTES:
        return adler32(data)
    if size <= _PAIR_BYTES:
        return adler32(data[:PIECE_BYTES]) + adler32(data[PIECE_BYTES:]) - 1
    count = size // PIECE_BYTES
    rest = data[count * PIECE_BYTES :]
    return sum(map(adler32, _splitter(count)(data))) + adler32(rest) - count


@cache
def _splitter(count: int) -> Callable[[bytes], tuple[bytes, ...]]:
    """Return a function that cuts off `count` pieces (at most 255), at half the cost of slices."""
    return Struct(f"{PIECE_BYTES}s" * count).unpack_from


def sum_function(size: int) -> Callable[[bytes], int]:
    """Return the fastest equivalent of `one_plus_sum` for data of exactly `size` bytes."""
    return adler32 if size <= PIECE_BYTES else one_plus_sum


class RunningSums:
    """Sums of any stretch of one buffer in constant time, after one pass over it.

    With it, a scan of hostile bytes takes linear time, although each may begin a frame of many kilobytes.
    """

    def __init__(self, buffer: bytes) -> None:
        self._sums = list(accumulate(buffer, initial=0))

    def one_plus_sum(self, start: int, end: int) -> int:
        """Return 1 + the sum of `buffer[start:end]`."""
        return self._sums[end] - self._sums[start] + 1
