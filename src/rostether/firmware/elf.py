"""The memory of an ELF file: sections, symbols, bytes at an address, and the debugging information.

It reads 32-bit little-endian files, the format of all supported microcontrollers, with DWARF 2 to 5.
This is the only module that imports pyelftools.
"""

from __future__ import annotations

import bisect
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from io import BytesIO
from pathlib import Path

from elftools.dwarf.compileunit import CompileUnit
from elftools.dwarf.die import DIE
from elftools.dwarf.lineprogram import LineProgram
from elftools.elf.elffile import ELFFile
from elftools.elf.enums import ENUM_ST_INFO_TYPE
from elftools.elf.sections import Section as ElfSection
from elftools.elf.sections import SymbolTableSection
from msgspec import Struct

from rostether.errors import FirmwareError
from rostether.firmware.debug_limits import (
    MAX_ATTRIBUTES,
    MAX_FILE_BYTES,
    MAX_LINES,
    Budget,
    lines_are_bounded,
)
from rostether.mechanisms.text import read_failure

# The kinds of symbols.
DATA, FUNCTION = 1, 2

_MAGIC = b"\x7fELF\x01\x01"
_WRITABLE, _ALLOCATED = 1, 2
_RESERVED_INDEX = 0xFF00
# Internal labels of compilers and assemblers, such as .L12 and L0\x01; newer binutils for AVR keep them.
_OWN_LABEL = re.compile(r"\.L|L\d+[\1\2]")
# avr-gcc places EEPROM, fuses and lock bits at addresses from here on: they are neither flash nor RAM.
_AVR_NO_MEMORY = 0x810000
_NAMED_TYPES = frozenset(
    f"DW_TAG_{kind}_type" for kind in ("class", "structure", "union", "enumeration", "base")
)
_SCOPES = _NAMED_TYPES | {"DW_TAG_namespace"}
_ORIGINS = ("DW_AT_specification", "DW_AT_abstract_origin")
_DEBUG_SECTIONS = (".debug_", ".zdebug_", ".eh_frame")
_ADDRESS_OPERATION = 0x03
# A damaged file may have entries that refer to each other.
_MAX_INDIRECTIONS = 16
# From this version of DWARF on, the first file has the number 0.
_FILES_FROM_ZERO = 5


class Section(Struct, frozen=True):
    """One section; `data` is empty if the file has no data for it."""

    name: str
    address: int
    size: int
    is_allocated: bool
    is_writable: bool
    has_bits: bool
    data: bytes


class Symbol(Struct, frozen=True):
    """A name for an address; `kind` is DATA, FUNCTION, or 0 if unknown."""

    name: str
    address: int
    size: int
    kind: int
    section: str


class CodeRange(Struct, frozen=True):
    """The instructions from `start` up to `end` that come from one line of a file, with inlined code."""

    start: int
    end: int
    file: str


class Variable(Struct, frozen=True):
    """A variable with a fixed address; `type_name` has namespaces, but no const and no reference."""

    name: str
    address: int
    type_name: str
    file: str


class ElfFile:
    """An ELF file's content. Raises FirmwareError for a file that is not ELF or is broken."""

    def __init__(self, content: bytes, name: str = "the file") -> None:
        if len(content) > MAX_FILE_BYTES:
            limit_mib = MAX_FILE_BYTES >> 20
            raise FirmwareError(
                f"{name} is larger than {limit_mib} MiB; give the ELF file of a microcontroller"
            )
        if content[:6] != _MAGIC:
            raise FirmwareError(
                f"{name} is not an ELF file of a microcontroller (32 bits, little endian); "
                "give the .elf file of a build"
            )
        self._content = content
        self._name = name
        try:
            self._file = ELFFile(BytesIO(content))
            self.is_avr: bool = self._file["e_machine"] == "EM_AVR"
            self.flags: int = self._file["e_flags"]
            # Not num_sections(): with a damaged file, it can return billions.
            self._parts = [self._file.get_section(index) for index in range(self._file["e_shnum"])]
            self.sections = [self._section(each) for each in self._parts]
        # The library raises errors of many types for a damaged file.
        except Exception as error:
            raise self._broken() from error
        if not self.sections:
            raise self._broken()

    @classmethod
    def read(cls, path: Path) -> ElfFile:
        """Read a file. Raises FirmwareError if it cannot be read."""
        try:
            return cls(path.read_bytes(), str(path))
        except OSError as error:
            raise FirmwareError(read_failure(path, error)) from None

    def section(self, name: str) -> Section | None:
        """Return a section by name, None if it does not exist."""
        return next((each for each in self.sections if each.name == name), None)

    def data(self, name: str) -> bytes:
        """Return a section's bytes, empty if there is no such section."""
        section = self.section(name)
        return b"" if section is None else section.data

    def is_in_memory(self, section: Section) -> bool:
        """Return whether a section uses flash or RAM."""
        is_elsewhere = self.is_avr and section.address >= _AVR_NO_MEMORY
        return section.is_allocated and section.size > 0 and not is_elsewhere

    @property
    def flash_bytes(self) -> int:
        """The flash use: code, constants, and initial values of variables."""
        return sum(each.size for each in self.sections if self.is_in_memory(each) and each.has_bits)

    @property
    def ram_bytes(self) -> int:
        """The RAM use of variables."""
        return sum(each.size for each in self.sections if self.is_in_memory(each) and each.is_writable)

    @cached_property
    def symbols(self) -> list[Symbol]:
        """All symbols that have an address, by address. Raises FirmwareError for a broken table."""
        try:
            return sorted(self._read_symbols(), key=lambda symbol: symbol.address)
        except Exception as error:
            raise self._broken() from error

    def read_at(self, address: int, size: int) -> bytes:
        """Return the bytes at an address; fewer if the section ends earlier."""
        for section in self.sections:
            if self.is_in_memory(section) and section.address <= address < section.address + section.size:
                start = address - section.address
                return section.data[start : start + size]
        return b""

    @cached_property
    def code_ranges(self) -> list[CodeRange]:
        """The source file of each piece of code, by address; assembler code is often missing."""
        ranges: list[CodeRange] = []
        budget = Budget(MAX_LINES)
        programs = {each.program_start_offset: each for each in self._programs.values()}
        # If the information is damaged, the part before the damage is still valid.
        with suppress(Exception):
            for _, program in sorted(programs.items()):
                ranges += _program_ranges(program, budget)
        return sorted(ranges, key=lambda each: each.start)

    def code_ranges_in(self, start: int, stop: int) -> Iterator[CodeRange]:
        """Yield the code ranges with at least one byte from `start` up to `stop`."""
        first = bisect.bisect_right(self.code_ranges, start, key=lambda each: each.start) - 1
        for each in self.code_ranges[max(first, 0) :]:
            if each.start >= stop:
                return
            if each.end > start:
                yield each

    @cached_property
    def variables(self) -> list[Variable]:
        """The variables in the debugging information; empty if it cannot be read."""
        variables: list[Variable] = []
        with suppress(Exception):
            # Read all entries first: an entry has a parent only after its unit was read in order.
            spend = Budget(MAX_ATTRIBUTES).spend
            entries = [e for unit in self._units for e in unit.iter_DIEs() if spend(1 + len(e.attributes))]
            for entry in entries:
                # avr-gcc 16 leaves references to entries that the linker has removed.
                with suppress(Exception):
                    variables += _variable(entry, self._programs)
        return variables

    @cached_property
    def _programs(self) -> dict[int, LineProgram]:
        """The line number programs of units, by the unit's offset."""
        programs = {}
        with suppress(Exception):
            for unit in self._units:
                line_table = unit.get_top_DIE().attributes.get("DW_AT_stmt_list")
                lines = unit.dwarfinfo.debug_line_sec
                if (
                    line_table is None
                    or lines is None
                    or not lines_are_bounded(lines.stream, line_table.value)
                ):
                    continue
                program = unit.dwarfinfo.line_program_for_CU(unit)
                if program is not None:
                    programs[unit.cu_offset] = program
        return programs

    @cached_property
    def _units(self) -> list[CompileUnit]:
        # In a damaged file, a compressed section, or one without content, could claim any amount of memory.
        is_bounded = all(
            each["sh_type"] != "SHT_NOBITS" and not each.compressed
            for each in self._parts
            if each.name.startswith(_DEBUG_SECTIONS)
        )
        if not is_bounded or not self._file.has_dwarf_info(strict=True):
            return []
        information = self._file.get_dwarf_info(relocate_dwarf_sections=False, follow_links=False)
        return list(information.iter_CUs())

    def _read_symbols(self) -> Iterator[Symbol]:
        for table in self._parts:
            if not isinstance(table, SymbolTableSection) or table["sh_type"] != "SHT_SYMTAB":
                continue
            for each in table.iter_symbols():
                index, kind = each["st_shndx"], each["st_info"]["type"]
                if _OWN_LABEL.match(each.name):
                    continue
                if isinstance(index, int) and 0 < index < _RESERVED_INDEX:
                    yield Symbol(
                        name=each.name,
                        address=each["st_value"],
                        size=each["st_size"],
                        kind=ENUM_ST_INFO_TYPE.get(kind, kind),
                        section=self.sections[index].name,
                    )

    def _section(self, section: ElfSection) -> Section:
        has_bits = section["sh_type"] != "SHT_NOBITS"
        start, size, flags = section["sh_offset"], section["sh_size"], section["sh_flags"]
        return Section(
            name=section.name,
            address=section["sh_addr"],
            size=size,
            is_allocated=bool(flags & _ALLOCATED),
            is_writable=bool(flags & _WRITABLE),
            has_bits=has_bits,
            data=self._content[start : start + size] if has_bits else b"",
        )

    def _broken(self) -> FirmwareError:
        return FirmwareError(f"{self._name} is a broken ELF file; build it again")


def _program_ranges(program: LineProgram, budget: Budget) -> Iterator[CodeRange]:
    earlier = None
    for entry in program.get_entries():
        budget.spend(1)
        state = entry.state
        if state is None:
            continue
        if earlier is not None and state.address > earlier.address:
            file = _file_name(program, earlier.file)
            if file:
                yield CodeRange(earlier.address, state.address, file)
        earlier = None if state.end_sequence else state


def _file_name(program: LineProgram, number: int) -> str:
    """Return a source file's path as given to the compiler; an empty string for an unknown number."""
    is_from_zero = program["version"] >= _FILES_FROM_ZERO
    index = number if is_from_zero else number - 1
    files, folders = program["file_entry"], program["include_directory"]
    if not 0 <= index < len(files):
        return ""
    name = _text(files[index].name)
    # Number 0 is the folder in which the compiler ran.
    in_folder = files[index].dir_index
    folder = _text(folders[in_folder if is_from_zero else in_folder - 1]) if in_folder else ""
    return f"{folder}/{name}" if folder and not name.startswith("/") else name


def _variable(entry: DIE, programs: Mapping[int, LineProgram]) -> Iterator[Variable]:
    location = entry.attributes.get("DW_AT_location")
    if entry.tag != "DW_TAG_variable" or location is None or not isinstance(location.value, list):
        return
    operation, *address = location.value
    if operation != _ADDRESS_OPERATION or len(address) < 2:
        return
    name, declared, type_holder = (
        _holder(entry, attribute) for attribute in ("DW_AT_name", "DW_AT_decl_file", "DW_AT_type")
    )
    file = ""
    if declared is not None and declared.cu.cu_offset in programs:
        number = declared.attributes["DW_AT_decl_file"].value
        file = _file_name(programs[declared.cu.cu_offset], number)
    yield Variable(
        name="" if name is None else _name(name),
        address=int.from_bytes(bytes(address), "little"),
        type_name="" if type_holder is None else _type_name(type_holder),
        file=file,
    )


def _holder(entry: DIE, attribute: str) -> DIE | None:
    """Return the entry that has an attribute: this one, or the declaration that it completes."""
    for _ in range(_MAX_INDIRECTIONS):
        if attribute in entry.attributes:
            return entry
        origin = next((each for each in _ORIGINS if each in entry.attributes), None)
        if origin is None:
            return None
        entry = entry.get_DIE_from_attribute(origin)
    return None


def _type_name(entry: DIE) -> str:
    for _ in range(_MAX_INDIRECTIONS):
        if "DW_AT_type" not in entry.attributes:
            return ""
        entry = entry.get_DIE_from_attribute("DW_AT_type")
        if entry.tag in _NAMED_TYPES:
            return "::".join(reversed([_name(each) for each in _enclosing(entry) if each.tag in _SCOPES]))
    return ""


def _enclosing(entry: DIE | None) -> Iterator[DIE]:
    while entry is not None:
        yield entry
        entry = entry.get_parent()


def _name(entry: DIE) -> str:
    attribute = entry.attributes.get("DW_AT_name")
    return "" if attribute is None else _text(attribute.value)


def _text(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else ""
