"""Where code and variables were written, by the compiler's debugging information.

Source: DWARF 2 to 4, sections 6.2 (line numbers) and 7 (encoding). Of what a newer compiler writes (DWARF 5)
nothing is read: then symbols are sorted by their names alone.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from rostether.firmware.dwarf_reader import DwarfReader
from rostether.firmware.elf import ElfFile

_NEWEST_VERSION = 4
_DAMAGE = (struct.error, IndexError, ValueError, ZeroDivisionError)


@dataclass(frozen=True, slots=True)
class CodeRange:
    """Instructions from `start` to before `end` that come from one line of a file, inlined code included."""

    start: int
    end: int
    file: str


def code_ranges(elf: ElfFile) -> list[CodeRange]:
    """Return which file each piece of code comes from, by address; code of assemblers is often missing."""
    data = elf.data(".debug_line")
    ranges: list[CodeRange] = []
    reader = DwarfReader(data)
    try:
        while reader.position < len(data):
            end = reader.position + 4 + struct.unpack_from("<I", data, reader.position)[0]
            ranges += _read_program(DwarfReader(data[:end], reader.position + 4))
            reader.position = end
    except _DAMAGE:
        pass  # what was read until here is still good
    return sorted(ranges, key=lambda each: each.start)


def file_tables(elf: ElfFile) -> dict[int, list[str]]:
    """Return the files of each line number program, by its offset; the first file has the number 1."""
    data = elf.data(".debug_line")
    tables = {}
    offset = 0
    try:
        while offset < len(data):
            header = _Header(DwarfReader(data, offset + 4))
            tables[offset] = header.files
            offset += 4 + struct.unpack_from("<I", data, offset)[0]
    except _DAMAGE:
        pass
    return tables


class _Header:
    def __init__(self, reader: DwarfReader) -> None:
        version = reader.number(2)
        header_length = reader.number(4)
        self.program = reader.position + header_length
        self.files: list[str] = []
        self.is_known = version <= _NEWEST_VERSION
        if not self.is_known:
            return
        self.minimum_length = reader.number(1)
        if version == _NEWEST_VERSION:
            reader.number(1)
        reader.number(1)
        self.line_base = reader.signed(1)
        self.line_range = reader.number(1)
        self.opcode_base = reader.number(1)
        self.operands = [reader.number(1) for _ in range(self.opcode_base - 1)]
        folders = [""]
        while folder := reader.text():
            folders.append(folder)
        while name := reader.text():
            folder = folders[reader.uleb()]
            reader.uleb(), reader.uleb()
            self.files.append(f"{folder}/{name}" if folder and not name.startswith("/") else name)


def _read_program(reader: DwarfReader) -> Iterator[CodeRange]:
    header = _Header(reader)
    if not header.is_known:
        return
    reader.position = header.program
    address, file = 0, 1
    row: tuple[int, int] | None = None

    def emit() -> Iterator[CodeRange]:
        if row is not None and address > row[0] and 0 < row[1] <= len(header.files):
            yield CodeRange(row[0], address, header.files[row[1] - 1])

    while reader.position < len(reader.data):
        opcode = reader.number(1)
        if opcode >= header.opcode_base:
            address += (opcode - header.opcode_base) // header.line_range * header.minimum_length
            yield from emit()
            row = (address, file)
        elif opcode == 0:
            length = reader.uleb()
            after = reader.position + length
            extended = reader.number(1)
            if extended == 1:  # end of sequence
                yield from emit()
                address, file, row = 0, 1, None
            elif extended == 2:  # set address
                address = reader.number(length - 1)
            reader.position = after
        elif opcode == 1:  # copy
            yield from emit()
            row = (address, file)
        elif opcode == 2:  # advance pc
            address += reader.uleb() * header.minimum_length
        elif opcode == 4:  # set file
            file = reader.uleb()
        elif opcode == 8:  # advance as the last special opcode would
            address += (255 - header.opcode_base) // header.line_range * header.minimum_length
        elif opcode == 9:  # fixed advance
            address += reader.number(2)
        else:
            for _ in range(header.operands[opcode - 1]):
                reader.uleb()
