"""The call graph of an AVR program, including calls through pointers, with the stack depth at each call."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property

from rostether.firmware.avr_code import Op, decode
from rostether.firmware.avr_pointers import PLAIN, UNKNOWN, table_functions
from rostether.firmware.elf import DATA, FUNCTION, ElfFile, Symbol
from rostether.firmware.stack_walk import Code, Walk, walk

# The bits of the ELF header's flags that name the architecture, and the value of avr6, whose program counter
# has 22 bits.
_MACHINE_FLAGS = 0x7F
_LARGE_FLASH = 6
_VECTOR = re.compile(r"__vector_\d+")
_CONSTRUCTORS = "_GLOBAL__sub_I_"
_VIRTUAL_TABLE = "_ZTV"
_NODE_TABLE = "_ZTVN3ros"
_NODE = "_ZN3ros"
_NODE_HANDLE = "_ZN3ros11NodeHandle_I"
_NODE_NAMESPACE = "ros::"
_LIBRARY_FILE = re.compile(r"^(?!.*/ros_lib/).*/(cores|libraries)/")
_TABLES_END = "__ctors_start"
# This function ends the program, and is in the tables of all abstract classes.
_PURE_VIRTUAL = "__cxa_pure_virtual"
# The compiler loads the two halves of an address within this number of instructions.
_LOAD_WINDOW = 4


class CallGraph:
    """The functions of a program, by the byte address of their first instruction (their entry).

    A call through a pointer may reach any function whose address is taken.
    """

    def __init__(self, elf: ElfFile) -> None:
        self._elf = elf
        self._functions = [
            each
            for each in elf.symbols
            if each.section == ".text" and each.kind in (0, FUNCTION) and each.name and each.address
        ]
        return_bytes = 3 if elf.flags & _MACHINE_FLAGS == _LARGE_FLASH else 2
        self._code = Code(
            flash=elf.data(".text"),
            entries={each.address: each.name for each in self._functions},
            sizes={each.address: each.size for each in self._functions if each.size},
            tables_end=next((each.address for each in elf.symbols if each.name == _TABLES_END), 0),
            return_bytes=return_bytes,
        )
        self._starts = {
            each.address // 2: each.address
            for each in self._functions
            if each.kind == FUNCTION and each.name != _PURE_VIRTUAL
        }
        self._walks: dict[int, Walk] = {}
        self._calls: dict[int, dict[int, int]] = {}

    @property
    def return_bytes(self) -> int:
        """The size of a return address on the stack."""
        return self._code.return_bytes

    @property
    def entry_points(self) -> list[int]:
        """The entry points: `main`, and the constructors of global objects before it."""
        return self._named(lambda name: name == "main" or name.startswith(_CONSTRUCTORS))

    @property
    def interrupts(self) -> list[int]:
        """The interrupts that the program handles."""
        unused = set(self._named(lambda name: name == "__bad_interrupt"))
        return sorted(set(self._named(lambda name: _VECTOR.fullmatch(name) is not None)) - unused)

    def name(self, entry: int) -> str:
        """Return a function's linker name."""
        return self._code.entries.get(entry, f"code at {entry:#x}")

    def walk(self, entry: int) -> Walk:
        """Return the stack use of a function."""
        if entry not in self._walks:
            self._walks[entry] = walk(self._code, entry)
        return self._walks[entry]

    def calls(self, entry: int) -> dict[int, int]:
        """Return the functions that a function may call, each with the stack depth of the deepest call."""
        if entry not in self._calls:
            here = self.walk(entry)
            calls = dict(here.calls)
            for kind, depth in here.indirect.items():
                for target in self._targets(kind, entry):
                    calls[target] = max(calls.get(target, 0), depth)
            self._calls[entry] = calls
        return self._calls[entry]

    def reachable(self, entries: Iterable[int], *, through_pointers: bool = True) -> list[int]:
        """Return the given functions and all functions that they call, directly or not."""
        seen: dict[int, None] = {}
        pending = list(entries)
        while pending:
            entry = pending.pop()
            if entry not in seen:
                seen[entry] = None
                pending += self.calls(entry) if through_pointers else self.walk(entry).calls
        return list(seen)

    def _targets(self, kind: int, caller: int) -> Iterable[int]:
        """Return the functions that a call through a kind of pointer may reach."""
        # The core and the libraries do not use node handles, their endpoints, or the functions that these
        # call.
        is_library_code = self._is_library_code(caller)
        plain = self._targets_outside_nodes if is_library_code else self._plain_targets
        if kind == PLAIN:
            return plain
        # A node handle calls its own functions directly; its calls through a table go to the hardware class.
        sees_nodes = not is_library_code and not self.name(caller).startswith(_NODE_HANDLE)
        virtual = {
            self._starts[word]
            for table in self._tables
            if sees_nodes or not table.name.startswith(_NODE_TABLE)
            for offset, word in table_functions(self._elf.read_at(table.address, table.size)).items()
            if word in self._starts and kind in (UNKNOWN, offset)
        }
        return {*plain, *virtual} if kind == UNKNOWN else virtual

    def _is_library_code(self, entry: int) -> bool:
        # The sketch's functions are inlined into main.
        code = next(self._elf.code_ranges_in(entry, entry + 1), None)
        return code is not None and bool(_LIBRARY_FILE.search(code.file)) and self.name(entry) != "main"

    @cached_property
    def _plain_targets(self) -> list[int]:
        """Functions whose address is in a variable, a table in flash, or a pair of load instructions."""
        return self._pointed_from([(each.address, each.size) for each in self._tables])

    @cached_property
    def _targets_outside_nodes(self) -> list[int]:
        """The plain targets that are also reached without endpoints."""
        sizes = {each.address: each.size for each in self._elf.symbols if each.size}
        hidden = [
            (each.address, sizes.get(each.address, 0))
            for each in self._elf.variables
            if each.type_name.startswith(_NODE_NAMESPACE)
        ]
        hidden += [(each.address, each.size) for each in self._tables]
        return [each for each in self._pointed_from(hidden) if not self.name(each).startswith(_NODE)]

    def _pointed_from(self, hidden: Iterable[tuple[int, int]]) -> list[int]:
        """Return the functions whose address occurs outside the given memory ranges."""
        values: set[int] = set(self._loaded_words())
        data = self._elf.section(".data")
        if data is not None:
            content = bytearray(data.data)
            for address, size in hidden:
                start = address - data.address
                if 0 <= start < len(content):
                    # In a damaged file, a size may be gigabytes.
                    end = min(start + size, len(content))
                    content[start:end] = bytes(end - start)
            values |= set(_words(bytes(content)))
        for each in self._elf.symbols:
            if each.section == ".text" and each.kind == DATA:
                values |= set(_words(self._elf.read_at(each.address, each.size)))
        return sorted(self._starts[value] for value in values & self._starts.keys())

    @property
    def _tables(self) -> list[Symbol]:
        return [
            each
            for each in self._elf.symbols
            if each.name.startswith(_VIRTUAL_TABLE) and each.section == ".data"
        ]

    def _named(self, is_wanted: Callable[[str], bool]) -> list[int]:
        return [each.address for each in self._functions if is_wanted(each.name)]

    def _loaded_words(self) -> Iterator[int]:
        flash = self._code.flash
        loads: list[tuple[int, int, int]] = []
        position = address = 0
        while address < len(flash):
            instruction = decode(flash, address)
            if instruction.op is Op.LOAD:
                for at, register, value in loads:
                    if position - at <= _LOAD_WINDOW and register + 1 == instruction.register:
                        yield instruction.value << 8 | value
                    if position - at <= _LOAD_WINDOW and register == instruction.register + 1:
                        yield value << 8 | instruction.value
                loads = [*loads[-_LOAD_WINDOW:], (position, instruction.register, instruction.value)]
            position += 1
            address += instruction.size


def _words(data: bytes) -> Iterator[int]:
    # Variables may also be at odd addresses.
    return (data[i] | data[i + 1] << 8 for i in range(len(data) - 1))
