"""Limits the cost of reading the debugging information of a damaged file.

The header of a DWARF 5 line program has tables of folders and files. A table states the number of its
entries, and the forms that each entry consists of. Entries without forms need no bytes, so a damaged header
of 40 bytes could make a reader loop forever. This module reads the header first and checks that its tables
are inside the file.
"""

from __future__ import annotations

from typing import IO

from rostether.errors import FirmwareError

# Ten times the numbers of the largest firmware of these microcontrollers.
MAX_FILE_BYTES = 64 * 1024 * 1024
MAX_ATTRIBUTES = 20_000_000
MAX_LINES = 5_000_000
# The header of a line program with a few thousand files.
_MAX_HEADER_BYTES = 1024 * 1024
# The version of DWARF whose header has these tables, and its codes for the forms of values.
_VERSION = 5
_DATA1, _DATA2, _DATA4, _DATA8, _DATA16 = 0x0B, 0x05, 0x06, 0x07, 0x1E
_STRING, _BLOCK, _UDATA = 0x08, 0x09, 0x0F
_STRP, _LINE_STRP = 0x0E, 0x1F
_SIZES = {_DATA1: 1, _DATA2: 2, _DATA4: 4, _DATA8: 8, _DATA16: 16, _STRP: 4, _LINE_STRP: 4}
# The offset of the length of the opcode table, after fields of fixed size.
_OPCODE_BASE = 17


class Budget:
    """The maximum cost of reading one kind of information."""

    def __init__(self, limit: int) -> None:
        self._left = limit

    def spend(self, count: int) -> bool:
        """Return True, for use in conditions. Raises FirmwareError if the budget is used up."""
        self._left -= count
        if self._left < 0:
            raise FirmwareError("the debugging information is damaged or too large; build it again")
        return True


def lines_are_bounded(lines: IO[bytes], offset: int) -> bool:
    """Return whether the tables of the line program at `offset` are inside the file; True before DWARF 5."""
    lines.seek(offset)
    header = lines.read(_MAX_HEADER_BYTES)
    if int.from_bytes(header[4:6], "little") != _VERSION:
        return True
    try:
        cursor = _Cursor(header, _OPCODE_BASE + header[_OPCODE_BASE])
        # Folders, then files.
        return cursor.skip_table() and cursor.skip_table()
    except IndexError:
        return False


class _Cursor:
    def __init__(self, data: bytes, offset: int) -> None:
        self._data = data
        self._offset = offset

    def skip_table(self) -> bool:
        """Skip a table; return False if its entries have no bytes or an unknown size."""
        forms = []
        for _ in range(self._byte()):
            self._number()
            forms.append(self._number())
        count = self._number()
        if count and not forms:
            return False
        for _ in range(count):
            for form in forms:
                if not self._skip_value(form):
                    return False
        return True

    def _skip_value(self, form: int) -> bool:
        if form == _STRING:
            self._offset = self._data.find(0, self._offset) + 1
            return self._offset > 0
        if form == _UDATA:
            self._number()
        elif form == _BLOCK:
            length = self._number()
            self._offset += length
        elif form in _SIZES:
            self._offset += _SIZES[form]
        else:
            return False
        return self._offset <= len(self._data)

    def _byte(self) -> int:
        byte = self._data[self._offset]
        self._offset += 1
        return byte

    def _number(self) -> int:
        """Read an unsigned LEB128 number."""
        value = shift = 0
        while True:
            byte = self._byte()
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value
