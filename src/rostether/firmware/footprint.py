"""A program's use of flash and RAM, by origin, and the room left for the stack.

Flash is what avr-size calls text and data, RAM is data and bss. Code, including inlined code, is grouped by
its source file; a variable by its type, else by the file that declares it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

from rostether.firmware.boards import Board
from rostether.firmware.built_firmware import BuiltFirmware
from rostether.firmware.demangle import demangle, shorten
from rostether.firmware.elf import DATA, ElfFile, Section, Symbol, Variable
from rostether.firmware.libraries import Origin
from rostether.firmware.origins import RUNTIME, START, TEXTS, Origins
from rostether.firmware.stack import StackEstimate, estimate_stack

# The reserve besides the estimated stack, for the registers of a second interrupt and for estimation errors.
MARGIN_BYTES = 64

# More names than these would not make a group clearer.
LARGEST_ITEMS = 5

_MANGLED = re.compile(r"_Z\w+")
_START_SYMBOLS = re.compile(
    r"__vectors|__ctors|__dtors|__init|__trampolines|__bad_interrupt|__do_(copy|clear|global)"
)


class Item(Struct, frozen=True):
    """The size of a variable, or of a function's code that belongs to a group.

    A variable with an initial value uses both flash and RAM.
    """

    name: str
    group: str
    flash_bytes: int
    ram_bytes: int


class Group(Struct, frozen=True):
    """The total size of one origin, and its largest functions and variables."""

    name: str
    flash_bytes: int
    ram_bytes: int
    largest: tuple[Item, ...]


class Footprint(Struct, frozen=True):
    """The flash, RAM and stack use of a program.

    Unknown limits are 0; `stack` is None for boards other than AVR.
    """

    board: Board
    flash_bytes: int
    ram_bytes: int
    groups: tuple[Group, ...]
    stack: StackEstimate | None

    @property
    def free_ram_bytes(self) -> int:
        """The RAM left after variables and the estimated stack; negative if they do not fit."""
        return self.board.ram_bytes - self.ram_bytes - (self.stack.total_bytes if self.stack else 0)

    @property
    def fits(self) -> bool:
        """Whether it can be flashed; as in the IDE, the stack does not count."""
        return not self.refusals()

    def refusals(self) -> list[str]:
        """Return the reasons why the program does not fit in the board's memory, one line each."""
        lines = []
        if self.board.flash_bytes and self.flash_bytes > self.board.flash_bytes:
            over = self.flash_bytes - self.board.flash_bytes
            lines.append(
                f"{self.flash_bytes} bytes of flash do not fit: {self.board.title} has "
                f"{self.board.flash_bytes} for programs, {over} fewer; {self._advice('flash_bytes')}"
            )
        if self.board.ram_bytes and self.ram_bytes > self.board.ram_bytes:
            over = self.ram_bytes - self.board.ram_bytes
            lines.append(
                f"variables of {self.ram_bytes} bytes do not fit in the {self.board.ram_bytes} bytes of RAM "
                f"of {self.board.title}: {over} too many; {self._advice('ram_bytes')}"
            )
        return lines

    def warnings(self) -> list[str]:
        """Return the expected problems at run time, one line each."""
        if not self.board.ram_bytes or self.stack is None or self.ram_bytes > self.board.ram_bytes:
            return []
        if self.free_ram_bytes >= MARGIN_BYTES:
            return []
        return [
            f"variables ({self.ram_bytes} bytes) and stack (up to {self.stack.total_bytes}) leave "
            f"{self.free_ram_bytes} of {self.board.ram_bytes} bytes of RAM: the stack may overwrite "
            f"variables; {self._advice('ram_bytes')}"
        ]

    def _advice(self, what: str) -> str:
        items = [each for group in self.groups for each in group.largest]
        largest = max(items, key=lambda each: getattr(each, what), default=None)
        if largest is None:
            return "make it smaller"
        return f"the largest is {largest.name} of {largest.group} ({getattr(largest, what)} bytes)"


async def measure(elf: Path | ElfFile, board: Board, origins: Origins | None = None) -> Footprint:
    """Measure an ELF file for a board. Raises FirmwareError if it is not an ELF file."""
    file = elf if isinstance(elf, ElfFile) else ElfFile.read(elf)
    origins = origins or Origins()
    stack = estimate_stack(file) if file.is_avr else None
    names = {each.name for each in file.symbols}
    readable = await demangle(names)
    counted = _Count(file, origins, readable)
    return Footprint(
        board=board,
        flash_bytes=file.flash_bytes,
        ram_bytes=file.ram_bytes,
        groups=tuple(counted.groups()),
        stack=None if stack is None else _readable_stack(stack, readable),
    )


async def measure_built(built: BuiltFirmware, elf: ElfFile | None = None) -> Footprint:
    """Measure a built firmware; the sketch's folder and its libraries are listed separately.

    `elf` is its ELF file if it was already read. Raises FirmwareError.
    """
    libraries = [(each.name, each.folder) for each in built.libraries if each.origin is not Origin.ROS]
    return await measure(elf or built.elf, built.board, Origins(built.sketch.folder, libraries))


class _Count:
    """Assigns each byte of a program to a group, and each symbol to a name."""

    def __init__(self, elf: ElfFile, origins: Origins, readable: Mapping[str, str]) -> None:
        self._elf = elf
        self._origins = origins
        self._readable = readable
        self._variables: dict[int, Variable] = {each.address: each for each in elf.variables}
        self._scopes = dict(self._scope_groups())
        self._groups: dict[str, list[int]] = {}
        self._items: list[Item] = []

    def groups(self) -> list[Group]:
        """Return the groups, the largest first."""
        for section in self._elf.sections:
            if self._elf.is_in_memory(section):
                self._count(section)
        found = [
            Group(name, flash, ram, tuple(self._largest(name)))
            for name, (flash, ram) in self._groups.items()
            if flash or ram
        ]
        return sorted(found, key=lambda group: (-group.flash_bytes - group.ram_bytes, group.name))

    def _largest(self, group: str) -> Sequence[Item]:
        own = [each for each in self._items if each.group == group]
        return sorted(own, key=lambda each: -each.flash_bytes - each.ram_bytes)[:LARGEST_ITEMS]

    def _count(self, section: Section) -> None:
        position = section.address
        end = section.address + section.size
        for symbol in self._sized(section):
            # Aliases and overlapping symbols count once.
            start = max(symbol.address, position)
            stop = min(symbol.address + symbol.size, end)
            if stop <= start:
                continue
            self._count_unnamed(section, position, start)
            self._count_symbol(section, symbol, start, stop)
            position = stop
        self._count_unnamed(section, position, end)

    def _count_symbol(self, section: Section, symbol: Symbol, start: int, stop: int) -> None:
        name = self._readable.get(symbol.name, symbol.name)
        if section.is_writable or symbol.kind == DATA:
            shares = {self._group_of_data(symbol, name) or RUNTIME: stop - start}
        else:
            shares = self._bytes_by_group(start, stop, self._group_of_code(start, name))
        for group, size in shares.items():
            self._add(group, section, size)
            flash, ram = size if section.has_bits else 0, size if section.is_writable else 0
            self._items.append(Item(_plain(shorten(name)), group, flash, ram))

    def _group_of_code(self, start: int, name: str) -> str:
        """Return the group of a function: the group of its first line's file, regardless of inlined code."""
        first = next(self._elf.code_ranges_in(start, start + 1), None)
        by_file = None if first is None else self._origins.of_file(first.file)
        runtime = START if _START_SYMBOLS.match(name) else RUNTIME
        return by_file or self._origins.of_name(name) or runtime

    def _group_of_data(self, symbol: Symbol, name: str) -> str | None:
        variable = self._variables.get(symbol.address)
        by_name = self._origins.of_name(name) or self._scopes.get(_scope(name))
        if variable is None:
            return by_name
        type_name = variable.type_name
        by_type = self._origins.of_name(type_name) or self._scopes.get(_scope(f"{type_name}::"))
        return by_type or by_name or self._origins.of_file(variable.file)

    def _scope_groups(self) -> Iterator[tuple[str, str]]:
        """Yield the classes that have functions here, with the group of their file."""
        for symbol in self._elf.symbols:
            scope = _scope(self._readable.get(symbol.name, symbol.name))
            if scope and symbol.section == ".text" and symbol.kind != DATA:
                yield scope, self._group_of_code(symbol.address, scope)

    def _count_unnamed(self, section: Section, start: int, stop: int) -> None:
        if stop <= start:
            return
        if section.is_writable:
            self._add(TEXTS if section.has_bits else RUNTIME, section, stop - start)
            return
        for group, size in self._bytes_by_group(start, stop, None).items():
            self._add(group, section, size)

    def _bytes_by_group(self, start: int, stop: int, otherwise: str | None) -> dict[str, int]:
        """Return the number of bytes of each group in a range of code."""
        shares: Counter[str] = Counter()
        position = start
        for each in self._elf.code_ranges_in(start, stop):
            self._count_gap(shares, position, each.start, otherwise)
            group = self._origins.of_file(each.file) or otherwise or RUNTIME
            first, position = max(each.start, position), min(each.end, stop)
            shares[group] += max(position - first, 0)
        self._count_gap(shares, position, stop, otherwise)
        return +shares

    def _count_gap(self, shares: Counter[str], start: int, stop: int, otherwise: str | None) -> None:
        if stop > start:
            shares[otherwise or self._unnamed_group(start)] += stop - start

    def _unnamed_group(self, address: int) -> str:
        """Return the group of code that no symbol with a size covers: start-up code or assembly code."""
        before = [
            each.name for each in self._elf.symbols if each.section == ".text" and each.address <= address
        ]
        return START if not before or _START_SYMBOLS.match(before[-1]) else RUNTIME

    def _sized(self, section: Section) -> list[Symbol]:
        found = [each for each in self._elf.symbols if each.section == section.name and each.size]
        return sorted(found, key=lambda symbol: (symbol.address, -symbol.size))

    def _add(self, group: str, section: Section, size: int) -> None:
        counted = self._groups.setdefault(group, [0, 0])
        counted[0] += size if section.has_bits else 0
        counted[1] += size if section.is_writable else 0


def _scope(name: str) -> str:
    """Return the class or namespace at the start of a readable name."""
    if name.startswith("vtable for "):
        name = name.removeprefix("vtable for ") + "::"
    scope, separator, _ = name.removeprefix("void ").partition("::")
    return scope if separator and "(" not in scope else ""


def _plain(name: str) -> str:
    """Return a readable name for a symbol that the compiler made."""
    if name.startswith(("_GLOBAL__sub_I", "global constructors")):
        return "constructors of global objects"
    name = re.sub(r"^__vector_(\d+)$", r"interrupt \1", name)
    return "main, with setup and loop" if name == "main" else name


def _readable_stack(stack: StackEstimate, readable: Mapping[str, str]) -> StackEstimate:
    def name(mangled: str) -> str:
        return _plain(shorten(readable.get(mangled, mangled)))

    return replace(
        stack,
        main_path=tuple(name(each) for each in stack.main_path),
        interrupt_path=tuple(name(each) for each in stack.interrupt_path),
        unknown=tuple(_MANGLED.sub(lambda match: name(match[0]), each) for each in stack.unknown),
    )
