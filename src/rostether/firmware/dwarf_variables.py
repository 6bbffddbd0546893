"""The variables of a program: where they are, what type they have, and which file declares them."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from rostether.firmware.dwarf import file_tables
from rostether.firmware.dwarf_reader import DwarfReader
from rostether.firmware.elf import ElfFile

_VARIABLE = 0x34
_NAMESPACE = 0x39
_NAMED_TYPES = frozenset((0x02, 0x13, 0x17, 0x04, 0x24))  # class, structure, union, enumeration, base type
_SCOPES = _NAMED_TYPES | {_NAMESPACE}
_NAME, _STATEMENTS, _LOCATION, _DECLARED_IN, _TYPE = 0x03, 0x10, 0x02, 0x3A, 0x49
_SPECIFICATION, _ABSTRACT_ORIGIN = 0x47, 0x31
_ADDRESS_OPERATION = 0x03
_NEWEST_VERSION = 4
_MAX_INDIRECTIONS = 16

Value = int | str | bytes


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable with a fixed address; `type_name` without const and reference, with its namespaces."""

    name: str
    address: int
    type_name: str
    file: str


@dataclass(slots=True)
class _Entry:
    tag: int
    attributes: dict[int, Value]
    parent: int
    unit: int


def read_variables(elf: ElfFile) -> list[Variable]:
    """Return the variables in the debugging information; none if it cannot be read."""
    files = file_tables(elf)
    try:
        entries, statements = _read_entries(elf)
    except (struct.error, IndexError, ValueError, KeyError):
        return []
    variables = []
    for entry in entries.values():
        location = entry.attributes.get(_LOCATION)
        if entry.tag != _VARIABLE or not isinstance(location, bytes) or len(location) < 3:
            continue
        if location[0] != _ADDRESS_OPERATION:
            continue
        table = files.get(statements.get(entry.unit, -1), [])
        number = _inherited(entries, entry, _DECLARED_IN)
        file = table[number - 1] if isinstance(number, int) and 0 < number <= len(table) else ""
        variables.append(
            Variable(
                name=str(_inherited(entries, entry, _NAME) or ""),
                address=int.from_bytes(location[1:], "little"),
                type_name=_type_name(entries, _inherited(entries, entry, _TYPE)),
                file=file,
            )
        )
    return variables


def _inherited(entries: dict[int, _Entry], entry: _Entry, attribute: int) -> Value | None:
    """Return an attribute, of what an entry completes if it has none itself."""
    for _ in range(_MAX_INDIRECTIONS):
        if attribute in entry.attributes:
            return entry.attributes[attribute]
        earlier = entry.attributes.get(_SPECIFICATION, entry.attributes.get(_ABSTRACT_ORIGIN))
        if not isinstance(earlier, int) or earlier not in entries:
            return None
        entry = entries[earlier]
    return None


def _type_name(entries: dict[int, _Entry], reference: Value | None) -> str:
    for _ in range(_MAX_INDIRECTIONS):
        if not isinstance(reference, int) or reference not in entries:
            return ""
        entry = entries[reference]
        if entry.tag in _NAMED_TYPES:
            return "::".join(reversed(list(_scopes(entries, reference))))
        reference = entry.attributes.get(_TYPE)
    return ""


def _scopes(entries: dict[int, _Entry], offset: int) -> Iterator[str]:
    while offset in entries:
        entry = entries[offset]
        if entry.tag in _SCOPES:
            yield str(entry.attributes.get(_NAME, ""))
        offset = entry.parent


def _read_entries(elf: ElfFile) -> tuple[dict[int, _Entry], dict[int, int]]:
    """Return all entries by offset, and for each unit the offset of its line number program."""
    data, strings = elf.data(".debug_info"), elf.data(".debug_str")
    entries: dict[int, _Entry] = {}
    statements: dict[int, int] = {}
    unit = 0
    while unit < len(data):
        end = unit + 4 + struct.unpack_from("<I", data, unit)[0]
        version, abbreviations_at, _ = struct.unpack_from("<HIB", data, unit + 4)
        if version <= _NEWEST_VERSION:
            abbreviations = _read_abbreviations(elf.data(".debug_abbrev"), abbreviations_at)
            reader = DwarfReader(data[:end], unit + 11)
            for offset, entry in _read_unit(reader, unit, abbreviations, strings):
                entries[offset] = entry
                found = entry.attributes.get(_STATEMENTS)
                if isinstance(found, int):
                    statements.setdefault(unit, found)
        unit = end
    return entries, statements


Abbreviations = dict[int, tuple[int, bool, list[tuple[int, int]]]]
_REFERENCES = frozenset((0x11, 0x12, 0x13, 0x14, 0x15))


def _read_abbreviations(data: bytes, offset: int) -> Abbreviations:
    reader = DwarfReader(data, offset)
    found: Abbreviations = {}
    while code := reader.uleb():
        tag, has_children = reader.uleb(), bool(reader.number(1))
        attributes = []
        while (pair := (reader.uleb(), reader.uleb())) != (0, 0):
            attributes.append(pair)
        found[code] = (tag, has_children, attributes)
    return found


def _read_unit(
    reader: DwarfReader, unit: int, abbreviations: Abbreviations, strings: bytes
) -> Iterator[tuple[int, _Entry]]:
    parents = [-1]
    while reader.position < len(reader.data) and parents:
        offset = reader.position
        code = reader.uleb()
        if code == 0:
            parents.pop()
            continue
        tag, has_children, forms = abbreviations[code]
        attributes: dict[int, Value] = {}
        for attribute, form in forms:
            value = reader.attribute(form, strings)
            # References count from their unit's beginning.
            attributes[attribute] = value + unit if form in _REFERENCES and isinstance(value, int) else value
        yield offset, _Entry(tag, attributes, parents[-1], unit)
        if has_children:
            parents.append(offset)
