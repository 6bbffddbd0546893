"""Explains why a device announces a type with an md5sum that differs from the known one.

A device only sends the md5sum. Its definition is found by trial: the known types, bundled earlier versions,
then the known type with one change (a missing field or constant, another width, another order, with or
without Header), then the same in its nested messages, then two changes at once.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations, islice
from typing import NamedTuple

from msgspec.structs import replace

from rostether.errors import DefinitionError
from rostether.msgdef.definition_files import earlier_files, read_definition
from rostether.msgdef.md5sum import declarations_text, digest, message_md5sum
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.primitives import PRIMITIVE_TYPES
from rostether.msgdef.registry import Registry
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.spec import Constant, Field, FieldType, MessageSpec

# Each takes about 10 µs, during which all boards wait: 30 ms for an error, once.
MAX_CANDIDATES = 3_000

# The types of the user's packages that are compared; each is read from disk.
MAX_KNOWN_TYPES = 2_000

# Types that users confuse: other widths, other signs, the old names of bytes.
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

# A definition with more differences is an unrelated one. The limit also keeps the line readable.
_MAX_LISTED = 6


def explain_mismatch(types: Registry, name: str, md5sum: str) -> str:
    """Return how a device's definition of `name` differs, as one line; `md5sum` is the announced one.

    Raises the errors of `types` for a type that is unknown or broken here.
    """
    known_type = types.message_type(name)
    start = f"{name}: the device's md5sum {md5sum} is not the known one ({known_type.md5sum})"
    advice = "generate its message headers again, or give its definition with --msg-path DIR"
    if known := name_of_md5sum(types, md5sum):
        return f"{start}; it belongs to {known}; {advice}"
    spec = types.message(name)
    for version, earlier in _earlier(spec):
        if message_md5sum(earlier, types.message) == md5sum:
            differing = difference(spec, earlier)
            return f"{start}; it belongs to {spec.package} {version}, which {differing}; {advice}"
    guess = guess_definition(types, name, md5sum)
    if guess is None:
        return f"{start}, nor that of any known definition; the known one is '{declarations(spec)}'; {advice}"
    whose = "its definition" if guess.full_name == name else f"its {guess.full_name}"
    return f"{start}: {whose} {difference(types.message(guess.full_name), guess)}; {advice}"


def name_of_md5sum(types: Registry, md5sum: str) -> str | None:
    """Return the name of a known message that has this md5sum, or None."""
    for known in islice(types.messages(), MAX_KNOWN_TYPES):
        try:
            if types.message_type(known).md5sum == md5sum:
                return known
        except DefinitionError:
            continue
    return None


def guess_definition(types: Registry, name: str, md5sum: str) -> MessageSpec | None:
    """Find a changed definition that gives `name` this md5sum, or None.

    The answer is another version of `name`, or (see its `full_name`) of one of its nested messages. Raises
    the errors of `types` for a type that is unknown or broken here.
    """
    root = types.message(name)
    below = dependencies(root, types.message)
    sums = {each.full_name: types.message_type(each.full_name).md5sum for each in below}
    sums[_HEADER.type.base] = types.message_type(_HEADER.type.base).md5sum
    for text, version, affected in islice(_candidates(root, below, sums), MAX_CANDIDATES):
        found = digest(text)
        if affected:
            known = {**sums, version.spec.full_name: found}
            for spec in affected:
                found = known[spec.full_name] = digest(declarations_text(spec.constants, spec.fields, known))
        if found == md5sum:
            return version.as_spec()
    return None


class _Version(NamedTuple):
    """A definition as the lines of its hashed text, each with its declaration: fast to change."""

    spec: MessageSpec
    constants: tuple[tuple[str, Constant], ...]
    fields: tuple[tuple[str, Field], ...]

    @classmethod
    def of(cls, spec: MessageSpec, sums: Mapping[str, str]) -> _Version:
        """Return a definition unchanged."""
        constants = tuple((declarations_text([each], (), sums), each) for each in spec.constants)
        fields = tuple((declarations_text((), [each], sums), each) for each in spec.fields)
        return cls(spec, constants, fields)

    def text(self) -> str:
        return "\n".join([line for line, _ in self.constants] + [line for line, _ in self.fields])

    def as_spec(self) -> MessageSpec:
        return replace(
            self.spec,
            constants=tuple(constant for _, constant in self.constants),
            fields=tuple(field for _, field in self.fields),
        )


def _earlier(spec: MessageSpec) -> Iterator[tuple[str, MessageSpec]]:
    for version, file in earlier_files(spec.package, spec.name).items():
        text = read_definition(file)
        yield version, parse_message(text, package=spec.package, name=spec.name, file=str(file))


def _candidates(
    root: MessageSpec, below: Sequence[MessageSpec], sums: Mapping[str, str]
) -> Iterator[tuple[str, _Version, Sequence[MessageSpec]]]:
    """Yield each candidate's text, the candidate, and the messages that contain it, innermost first."""
    version = _Version.of(root, sums)
    ordered = _bottom_up(root, below)
    header = (declarations_text((), [_HEADER], sums), _HEADER)
    for once in _changed(version, header):
        yield once.text(), once, ()
    for nested in below:
        affected = _holders(nested, ordered)
        for once in _changed(_Version.of(nested, sums), header):
            yield once.text(), once, affected
    # Two changes are usually fields that a later version added in two places.
    for two in combinations(range(len(version.fields)), 2):
        kept = tuple(each for index, each in enumerate(version.fields) if index not in two)
        twice = version._replace(fields=kept)
        yield twice.text(), twice, ()
    for once in _changed(version, header):
        for twice in _changed(once, header):
            yield twice.text(), twice, ()


def _changed(version: _Version, header: tuple[str, Field]) -> Iterator[_Version]:
    """Yield the definitions that are one likely edit away."""
    spec, constants, fields = version
    if constants:
        yield _Version(spec, (), fields)
    for start, end in combinations(range(len(fields) + 1), 2):
        yield _Version(spec, constants, fields[:start] + fields[end:])
    for start, end in combinations(range(len(constants) + 1), 2):
        yield _Version(spec, constants[:start] + constants[end:], fields)
    if header not in fields:
        yield _Version(spec, constants, (header, *fields))
    for index, (_, field) in enumerate(fields):
        for type_ in _other_types(field.type):
            entry = (f"{type_} {field.name}", Field(type_, field.name))
            yield _Version(spec, constants, (*fields[:index], entry, *fields[index + 1 :]))
    for index, (_, constant) in enumerate(constants):
        for other in _other_bases(constant.type):
            changed = (f"{other} {constant.name}={constant.text}", replace(constant, type=other))
            yield _Version(spec, (*constants[:index], changed, *constants[index + 1 :]), fields)
    for index in range(len(fields) - 1):
        swapped = (*fields[:index], fields[index + 1], fields[index], *fields[index + 2 :])
        yield _Version(spec, constants, swapped)


def _other_types(type_: FieldType) -> Iterator[FieldType]:
    for other in _other_bases(type_.base):
        yield replace(type_, base=other)
    if type_.base in PRIMITIVE_TYPES:
        # A single value instead of an array and the reverse, and a variable length instead of a fixed one.
        yield FieldType(type_.base, is_array=not type_.is_array or type_.length is not None)


@functools.lru_cache(maxsize=256)  # peers may send any number of names
def _other_bases(base: str) -> tuple[str, ...]:
    return tuple(other for group in _ALTERNATIVES if base in group for other in group if other != base)


def _bottom_up(root: MessageSpec, below: Sequence[MessageSpec]) -> list[MessageSpec]:
    """Return all messages in an order in which each follows those that it contains."""
    specs = {each.full_name: each for each in below}
    ordered: dict[str, MessageSpec] = {}

    def visit(spec: MessageSpec) -> None:
        for field in spec.fields:
            base = field.type.base
            if base in specs and base not in ordered:
                visit(specs[base])
        ordered[spec.full_name] = spec

    visit(root)
    return list(ordered.values())


def _holders(nested: MessageSpec, ordered: Sequence[MessageSpec]) -> list[MessageSpec]:
    """Return the messages that contain `nested`, directly or indirectly, in the given order."""
    changed = {nested.full_name}
    holders: list[MessageSpec] = []
    for spec in ordered:
        if any(field.type.base in changed for field in spec.fields):
            changed.add(spec.full_name)
            holders.append(spec)
    return holders


def difference(known: MessageSpec, found: MessageSpec) -> str:
    """Describe the missing, additional and different declarations of `found`; empty if all are the same."""
    differences = [
        *_declaration_differences(_fields_by_name(known), _fields_by_name(found), ""),
        *_declaration_differences(_constants_by_name(known), _constants_by_name(found), "the constant "),
    ]
    if not differences and (known.fields, known.constants) != (found.fields, found.constants):
        differences = [_order_difference(known, found)]
    if len(differences) > _MAX_LISTED:
        differences[_MAX_LISTED:] = [f"and {len(differences) - _MAX_LISTED} more differences"]
    return ", ".join(differences)


def declarations(spec: MessageSpec) -> str:
    """Return the fields as one line: `Header header, float32 range`."""
    return _listed(spec.fields) or "no fields"


def _declaration_differences(known: Mapping[str, str], found: Mapping[str, str], noun: str) -> Iterable[str]:
    for name, text in known.items():
        if name not in found:
            yield f"lacks {noun}'{text}'"
        elif found[name] != text:
            yield f"has '{found[name]}' instead of '{text}'"
    for name, text in found.items():
        if name not in known:
            yield f"also has {noun}'{text}'"


def _fields_by_name(spec: MessageSpec) -> dict[str, str]:
    return {field.name: f"{field.type} {field.name}" for field in spec.fields}


def _constants_by_name(spec: MessageSpec) -> dict[str, str]:
    return {each.name: f"{each.type} {each.name}={each.text}" for each in spec.constants}


def _order_difference(known: MessageSpec, found: MessageSpec) -> str:
    if known.fields == found.fields:
        return "declares the constants in another order"
    return f"declares the fields in another order: {_listed(found.fields)}"


def _listed(fields: Iterable[Field]) -> str:
    texts = [f"{field.type} {field.name}" for field in fields]
    if len(texts) > _MAX_LISTED:
        texts[_MAX_LISTED:] = [f"and {len(texts) - _MAX_LISTED} more fields"]
    return ", ".join(texts)
