"""The parts of an ELF file that say what takes memory: sections, symbols, and the bytes at an address.

Source: System V ABI, chapter 4. 32 bits and little endian, as all microcontrollers of ours have it.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from rostether.errors import FirmwareError

_MAGIC = b"\x7fELF\x01\x01"
_HEADER = struct.Struct("<HHIIIIIHHHHHH")
_SECTION = struct.Struct("<10I")
_SYMBOL = struct.Struct("<IIIBBH")
_SYMBOL_TABLE = 2
_NO_BITS = 8
_WRITABLE, _ALLOCATED = 1, 2
_RESERVED_INDEX = 0xFF00
# avr-gcc gives EEPROM, fuses and lock bits addresses from here on: they are neither flash nor RAM.
_AVR_MACHINE = 83
_AVR_NO_MEMORY = 0x810000


@dataclass(frozen=True, slots=True)
class Section:
    """One section; `data` is empty where the file holds none for it."""

    name: str
    address: int
    size: int
    is_allocated: bool
    is_writable: bool
    has_bits: bool
    data: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name for an address; `kind` is 1 for data, 2 for a function, 0 where the assembler did not say."""

    name: str
    address: int
    size: int
    kind: int
    section: str


class ElfFile:
    """An ELF file's content. Raises FirmwareError for what is none."""

    def __init__(self, content: bytes, name: str = "the file") -> None:
        if content[:6] != _MAGIC:
            raise FirmwareError(f"{name} is no ELF file of a microcontroller (32 bits, little endian)")
        self._content = content
        self._name = name
        try:
            header = _HEADER.unpack_from(content, 16)
            self.machine: int = header[1]
            self.flags: int = header[6]
            self._headers = [
                _SECTION.unpack_from(content, header[5] + index * header[10]) for index in range(header[11])
            ]
            names = self._bits(self._headers[header[12]])
            self.sections = [self._section(each, names) for each in self._headers]
        except (struct.error, IndexError):
            raise FirmwareError(f"{name} is a broken ELF file; build it again") from None

    @classmethod
    def read(cls, path: Path) -> ElfFile:
        """Read a file. Raises FirmwareError when it cannot be read."""
        try:
            return cls(path.read_bytes(), str(path))
        except OSError as error:
            raise FirmwareError(f"cannot read {path}: {error.strerror}") from None

    @property
    def is_avr(self) -> bool:
        """Whether it is a program for an 8-bit AVR."""
        return self.machine == _AVR_MACHINE

    def section(self, name: str) -> Section | None:
        """Return a section by name."""
        return next((each for each in self.sections if each.name == name), None)

    def data(self, name: str) -> bytes:
        """Return a section's bytes, none when there is no such section."""
        section = self.section(name)
        return b"" if section is None else section.data

    def in_memory(self, section: Section) -> bool:
        """Tell whether a section takes flash or RAM."""
        is_elsewhere = self.is_avr and section.address >= _AVR_NO_MEMORY
        return section.is_allocated and section.size > 0 and not is_elsewhere

    @property
    def flash_bytes(self) -> int:
        """What is written to flash: code, constants, and the values that variables begin with."""
        return sum(each.size for each in self.sections if self.in_memory(each) and each.has_bits)

    @property
    def ram_bytes(self) -> int:
        """What variables take from the first instruction on."""
        return sum(each.size for each in self.sections if self.in_memory(each) and each.is_writable)

    @cached_property
    def symbols(self) -> list[Symbol]:
        """All symbols that have an address, by address. Raises FirmwareError for a broken table."""
        try:
            return sorted(self._read_symbols(), key=lambda symbol: symbol.address)
        except (struct.error, IndexError):
            raise FirmwareError(f"{self._name} is a broken ELF file; build it again") from None

    def _read_symbols(self) -> Iterator[Symbol]:
        for header in self._headers:
            if header[1] != _SYMBOL_TABLE:
                continue
            names = self._bits(self._headers[header[6]])
            for name, value, size, info, _, index in _SYMBOL.iter_unpack(self._bits(header)):
                if 0 < index < _RESERVED_INDEX:
                    yield Symbol(_text(names, name), value, size, info & 0xF, self.sections[index].name)

    def read_at(self, address: int, size: int) -> bytes:
        """Return bytes that the file has for an address; fewer when it has not so many."""
        for section in self.sections:
            if self.in_memory(section) and section.address <= address < section.address + section.size:
                start = address - section.address
                return section.data[start : start + size]
        return b""

    def _section(self, header: tuple[int, ...], names: bytes) -> Section:
        return Section(
            name=_text(names, header[0]),
            address=header[3],
            size=header[5],
            is_allocated=bool(header[2] & _ALLOCATED),
            is_writable=bool(header[2] & _WRITABLE),
            has_bits=header[1] != _NO_BITS,
            data=self._bits(header),
        )

    def _bits(self, header: tuple[int, ...]) -> bytes:
        return b"" if header[1] == _NO_BITS else self._content[header[4] : header[4] + header[5]]


def _text(names: bytes, offset: int) -> str:
    return names[offset : names.find(b"\0", offset)].decode("utf-8", "replace")
