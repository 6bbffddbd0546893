"""Numbers and texts as DWARF encodes them."""

from __future__ import annotations

_SIZES = {
    0x01: 4,
    0x0B: 1,
    0x05: 2,
    0x06: 4,
    0x07: 8,
    0x0C: 1,
    0x10: 4,
    0x11: 1,
    0x12: 2,
    0x13: 4,
    0x14: 8,
    0x17: 4,
}
"""Forms of a fixed size: addresses, data1 to data8, flag, references, offsets into other sections."""
_BLOCK_LENGTHS = {0x03: 2, 0x04: 4, 0x0A: 1}
_STRING, _INDIRECT_STRING = 0x08, 0x0E
_SDATA, _UDATA, _REFERENCE_UDATA, _EXPRESSION = 0x0D, 0x0F, 0x15, 0x18
_PRESENT = 0x19
_TYPE_SIGNATURE = 0x20


class DwarfReader:
    """Reads on from a position. Raises IndexError beyond the end, ValueError for a form it does not know."""

    def __init__(self, data: bytes, position: int = 0) -> None:
        self.data = data
        self.position = position

    def number(self, size: int) -> int:
        """Read an unsigned number of some bytes."""
        return int.from_bytes(self._take(size), "little")

    def signed(self, size: int) -> int:
        """Read a signed number of some bytes."""
        return int.from_bytes(self._take(size), "little", signed=True)

    def uleb(self) -> int:
        """Read an unsigned number in groups of seven bits."""
        result = shift = 0
        while True:
            byte = self.data[self.position]
            self.position += 1
            result |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return result

    def text(self) -> str:
        """Read a text up to its NUL."""
        end = self.data.index(b"\0", self.position)
        start, self.position = self.position, end + 1
        return self.data[start:end].decode("utf-8", "replace")

    def attribute(self, form: int, strings: bytes) -> int | str | bytes:
        """Read an attribute's value in one of the forms of DWARF 2 to 4."""
        size = _SIZES.get(form)
        if size is not None:
            return self.number(size)
        if form == _INDIRECT_STRING:
            offset = self.number(4)
            return strings[offset : strings.index(b"\0", offset)].decode("utf-8", "replace")
        if form == _STRING:
            return self.text()
        if form in _BLOCK_LENGTHS:
            return self._take(self.number(_BLOCK_LENGTHS[form]))
        if form in (0x09, _EXPRESSION):
            return self._take(self.uleb())
        if form in (_UDATA, _SDATA, _REFERENCE_UDATA):
            return self.uleb()
        if form == _PRESENT:
            return 1
        if form == _TYPE_SIGNATURE:
            return self.number(8)
        raise ValueError(f"unknown DWARF form {form:#x}")

    def _take(self, size: int) -> bytes:
        start, self.position = self.position, self.position + size
        if self.position > len(self.data):
            raise IndexError("beyond the end")
        return self.data[start : self.position]
