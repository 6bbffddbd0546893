"""A position of generated code in its input or output, as far as it is known during the generation."""

from __future__ import annotations

import struct
from math import gcd
from typing import Final

# ROS 2 middlewares write each UTF-16 unit of a wstring with four bytes.
UNIT_BYTES: Final = 4


class Offset:
    """An expression of an index into a payload.

    With `is_aligned`, the payload is CDR, whose alignment counts from index 4. The distance of the position
    from there, modulo `modulus` (1, 2, 4 or 8), is `residue`. Otherwise, nothing is aligned.
    """

    __slots__ = ("is_aligned", "modulus", "offset", "residue", "start")

    def __init__(
        self, start: str, offset: int, *, is_aligned: bool, modulus: int = 8, residue: int = 0
    ) -> None:
        self.start = start
        self.offset = offset
        self.is_aligned = is_aligned
        self.modulus = modulus
        self.residue = residue

    def text(self, ahead: int = 0) -> str:
        """Return the expression of the position, or of one `ahead` bytes further."""
        offset = self.offset + ahead
        if not self.start:
            return str(offset)
        return f"{self.start} + {offset}" if offset else self.start

    def advance(self, size: int) -> None:
        """Skip bytes."""
        self.offset += size
        self.residue = (self.residue + size) % self.modulus

    def move(self, start: str, step: int = 1) -> None:
        """Go to the position that an expression gives, a multiple of `step` bytes further."""
        self.start, self.offset = start, 0
        self.modulus = gcd(self.modulus, step)
        self.residue %= self.modulus

    def padding(self, alignment: int) -> int | None:
        """Return the padding to an alignment, None if it is known only at run time."""
        if not self.is_aligned or alignment == 1:
            return 0
        return -self.residue % alignment if self.modulus >= alignment else None

    def align(self, variable: str, alignment: int) -> str:
        """Go to the next aligned position, and return the line of code that stores it in a variable."""
        end = f"({self.text(3)} & -8) + 4" if alignment == 8 else f"{self.text(alignment - 1)} & -{alignment}"
        self.start, self.offset = variable, 0
        self.modulus, self.residue = alignment, 0
        return f"{variable} = {end}"

    def copy(self) -> Offset:
        """Return a copy."""
        return Offset(
            self.start, self.offset, is_aligned=self.is_aligned, modulus=self.modulus, residue=self.residue
        )


def widen(text: bytes) -> bytes:
    """Return a UTF-8 text as the UTF-16 units of a wstring in CDR, without their count."""
    encoded = text.decode("utf-8", "replace").encode("utf-16-le")
    count = len(encoded) // 2
    return struct.pack(f"<{count}I", *struct.unpack(f"<{count}H", encoded))


def narrow(units: bytes) -> bytes:
    """Return the UTF-16 units of a wstring in CDR as a UTF-8 text. Raises struct.error above 16 bits."""
    count = len(units) // UNIT_BYTES
    encoded = struct.pack(f"<{count}H", *struct.unpack_from(f"<{count}I", units))
    return encoded.decode("utf-16-le", "replace").encode()
