"""What a device means that announces a type with another md5sum than ours.

A device only tells the md5sum. Its definition is found by trying: the types we know, earlier versions that
we bring along, then ours with one change (a field or constant less, another width, another order, with or
without Header), then the same in the messages below ours, then two changes at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import combinations, islice
from typing import Protocol

from rostether.errors import DefinitionError
from rostether.msgdef.definition_files import earlier_files, read_definition
from rostether.msgdef.difference import declarations, difference
from rostether.msgdef.interface import MessageType
from rostether.msgdef.md5sum import declarations_text, digest, message_md5sum
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.primitives import PRIMITIVE_TYPES
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.spec import Field, FieldType, MessageSpec

MAX_CANDIDATES = 3_000  # some 10 us each, and all boards wait for it: one line may take 30 ms, once
MAX_KNOWN_TYPES = 2_000  # types of the user's packages to compare with; each is read from disk

# Types that one takes for another: other widths, other signs, the old names of bytes.
_ALTERNATIVES = (
    ("bool", "byte", "char", "int8", "uint8"),
    ("int8", "int16", "int32", "int64"),
    ("uint8", "uint16", "uint32", "uint64"),
    ("int16", "uint16"),
    ("int32", "uint32", "float32"),
    ("int64", "uint64"),
    ("float32", "float64"),
)
_HEADER = Field(FieldType("std_msgs/Header"), "header")


class Types(Protocol):
    """What a registry gives."""

    def message(self, name: str) -> MessageSpec:
        """Return a definition."""

    def message_type(self, name: str) -> MessageType:
        """Return a type with its md5sum."""

    def messages(self, package: str | None = None) -> list[str]:
        """List all messages."""


def explain_mismatch(types: Types, name: str, md5sum: str) -> str:
    """Return one line on a device that announced `name` with `md5sum`: the difference, if it can be found.

    Raises what `types` raises for a type that is unknown or broken on our side.
    """
    ours = types.message_type(name)
    start = f"{name}: the device's md5sum {md5sum} is not ours ({ours.md5sum})"
    advice = "rebuild its message headers, or give its definition with --msg-path DIR"
    if known := name_of_md5sum(types, md5sum):
        return f"{start}, it is that of {known}; {advice}"
    spec = types.message(name)
    for version, earlier in _earlier(spec):
        if message_md5sum(earlier, types.message) == md5sum:
            said = difference(spec, earlier)
            return f"{start}, it is that of {spec.package} {version}, which {said}; {advice}"
    guess = guess_definition(types, name, md5sum)
    if guess is None:
        return f"{start}, and of no definition we know; ours is '{declarations(spec)}'; {advice}"
    whose = "its definition" if guess.full_name == name else f"its {guess.full_name}"
    return f"{start}: {whose} {difference(types.message(guess.full_name), guess)}; {advice}"


def name_of_md5sum(types: Types, md5sum: str) -> str | None:
    """Return the name of a known message that has this md5sum, or None."""
    for known in islice(types.messages(), MAX_KNOWN_TYPES):
        try:
            if types.message_type(known).md5sum == md5sum:
                return known
        except DefinitionError:
            continue
    return None


def guess_definition(types: Types, name: str, md5sum: str) -> MessageSpec | None:
    """Find a changed definition that gives `name` this md5sum, or None.

    The answer is another version of `name`, or (see its `full_name`) of one of the messages below it.
    """
    ours = types.message(name)
    below = dependencies(ours, types.message)
    sums = {each: types.message_type(each).md5sum for each in (_HEADER.type.base, name)}
    sums.update({each.full_name: types.message_type(each.full_name).md5sum for each in below})
    for candidate in islice(_candidates(ours, below), MAX_CANDIDATES):
        found = digest(declarations_text(candidate.constants, candidate.fields, sums))
        if candidate.full_name != name:
            found = _md5sum_over(ours, below, sums, candidate.full_name, found)
        if found == md5sum:
            return candidate
    return None


def _earlier(spec: MessageSpec) -> Iterator[tuple[str, MessageSpec]]:
    for version, file in earlier_files(spec.package, spec.name).items():
        text = read_definition(file)
        yield version, parse_message(text, package=spec.package, name=spec.name, file=str(file))


def _candidates(ours: MessageSpec, below: Iterable[MessageSpec]) -> Iterator[MessageSpec]:
    yield from _changed(ours)
    for nested in below:
        yield from _changed(nested)
    # Fields that a later version added in several places are what two changes mostly are.
    for two in combinations(range(len(ours.fields)), 2):
        yield replace(ours, fields=tuple(f for index, f in enumerate(ours.fields) if index not in two))
    for once in _changed(ours):
        yield from _changed(once)


def _changed(spec: MessageSpec) -> Iterator[MessageSpec]:
    """Yield the definitions that are one likely edit away."""
    fields, constants = spec.fields, spec.constants
    if constants:
        yield replace(spec, constants=())
    for start in range(len(fields)):
        for end in range(start + 1, len(fields) + 1):
            yield replace(spec, fields=fields[:start] + fields[end:])
    for start in range(len(constants)):
        for end in range(start + 1, len(constants) + 1):
            yield replace(spec, constants=constants[:start] + constants[end:])
    if _HEADER not in fields:
        yield replace(spec, fields=(_HEADER, *fields))
    for index, field in enumerate(fields):
        for type_ in _other_types(field.type):
            changed = Field(type_, field.name)
            yield replace(spec, fields=(*fields[:index], changed, *fields[index + 1 :]))
    for index, constant in enumerate(constants):
        for type_ in _other_types(FieldType(constant.type)):
            if not type_.is_array:
                other = replace(constant, type=type_.base)
                yield replace(spec, constants=(*constants[:index], other, *constants[index + 1 :]))
    for index in range(len(fields) - 1):
        swapped = (*fields[:index], fields[index + 1], fields[index], *fields[index + 2 :])
        yield replace(spec, fields=swapped)


def _other_types(type_: FieldType) -> Iterator[FieldType]:
    for group in _ALTERNATIVES:
        if type_.base in group:
            for other in group:
                if other != type_.base:
                    yield replace(type_, base=other)
    if type_.base in PRIMITIVE_TYPES:
        if not type_.is_array:
            yield FieldType(type_.base, is_array=True)
        elif type_.length is None:
            yield FieldType(type_.base)
        else:
            yield FieldType(type_.base, is_array=True)


def _md5sum_over(
    ours: MessageSpec, below: Iterable[MessageSpec], sums: Mapping[str, str], changed: str, md5sum: str
) -> str:
    """Return the md5sum of `ours` if the message `changed` had another one."""
    specs = {each.full_name: each for each in below}
    known = {changed: md5sum}

    def sum_of(spec: MessageSpec) -> str:
        bases = {field.type.base for field in spec.fields} - PRIMITIVE_TYPES
        for base in bases:
            if base not in known:
                known[base] = sum_of(specs[base])
        return digest(declarations_text(spec.constants, spec.fields, {**sums, **known}))

    return sum_of(ours)
