"""Lists the messages inside a message, in the order of full texts, within safe limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeAlias, TypeVar

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.msgdef.spec import MessageSpec

Lookup: TypeAlias = Callable[[str], MessageSpec]
SpecT = TypeVar("SpecT", bound="_Message")

# Definitions also come from peers; messages in use have at most about 8 levels.
MAX_DEPTH = 32
# The values that every message contains because of fixed arrays and nesting; messages in use have at most a
# few thousand. With two fields of the next type on each of 32 levels, 1 KB of text would mean 4e9 values.
MAX_FIXED_VALUES = 1 << 20

# A fixed array of bytes is one value in memory, so it counts by size only.
_BYTES_PER_VALUE = 256


class _Type(Protocol):
    """The type of a field, of ROS 1 or ROS 2."""

    @property
    def base(self) -> str: ...
    @property
    def is_array(self) -> bool: ...
    @property
    def length(self) -> int | None: ...


class _Field(Protocol):
    """A field of a message, of ROS 1 or ROS 2."""

    @property
    def name(self) -> str: ...
    @property
    def type(self) -> _Type: ...


class _Message(Protocol):
    """A message, of ROS 1 or ROS 2."""

    @property
    def full_name(self) -> str: ...
    @property
    def fields(self) -> Sequence[_Field]: ...


def dependencies(spec: SpecT, lookup: Callable[[str], SpecT]) -> list[SpecT]:
    """Return all nested messages of `spec`, each once, in the order of first use, depth first.

    `lookup` maps a full name to its definition. Raises UnknownTypeError, which names the field with the
    missing type, and DefinitionError for a type that contains itself, is nested too deeply or is too large.
    """
    walk: _Walk[SpecT] = _Walk(lookup)
    walk.visit(spec, (spec.full_name,))
    return list(walk.found.values())


class _Walk(Generic[SpecT]):
    def __init__(self, lookup: Callable[[str], SpecT]) -> None:
        self.found: dict[str, SpecT] = {}
        self._lookup = lookup
        self._values: dict[str, int] = {}

    def visit(self, spec: SpecT, path: tuple[str, ...]) -> int:
        """Add all nested messages of `spec`, and return how many values one message of `spec` contains."""
        if len(path) > MAX_DEPTH:
            raise DefinitionError(
                f"messages are nested deeper than {MAX_DEPTH} levels: {' -> '.join(path)}", file=path[0]
            )
        total = 0
        for field in spec.fields:
            if "/" not in field.type.base:  # a primitive
                total += _primitive_values(field)
                continue
            each = self._visit_field(spec, field, path)
            if not field.type.is_array:
                total += each
            elif field.type.length is not None:
                total += each * field.type.length
        if total > MAX_FIXED_VALUES:
            raise DefinitionError(
                f"every message would have {total} values, more than {MAX_FIXED_VALUES}; use arrays of"
                " variable length",
                file=spec.full_name,
            )
        self._values[spec.full_name] = total
        return total

    def _visit_field(self, spec: SpecT, field: _Field, path: tuple[str, ...]) -> int:
        name = field.type.base
        if name in path:
            cycle = " -> ".join((*path[path.index(name) :], name))
            raise DefinitionError(f"a message cannot contain itself: {cycle}", file=spec.full_name)
        if name in self._values:
            return self._values[name]
        try:
            nested = self._lookup(name)
        except UnknownTypeError as error:
            raise UnknownTypeError(f"{spec.full_name}, field {field.name!r}: {error}") from error
        self.found[name] = nested
        return self.visit(nested, (*path, name))


def _primitive_values(field: _Field) -> int:
    length = field.type.length
    if not field.type.is_array or length is None:
        return 1
    return 1 + length // _BYTES_PER_VALUE if field.type.base in ("uint8", "char", "byte") else length
