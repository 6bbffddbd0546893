"""Message types resolved for serialization: trees of numbers, stamps, text, arrays and structs.

Layouts and codecs are compiled from a tree. Everything about a type that is expensive to compute is computed
here once: its size on the wire if it is constant, and whether its zero value fits in memory (definitions also
come from peers).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Protocol, TypeAlias

import msgspec

from rostether.errors import DefinitionError
from rostether.msgdef.spec import Constant, FieldType, MessageSpec

# The limit of nested types. Real ones are below 10; compilation recurses, so a peer's text must be limited.
MAX_DEPTH: Final = 32

# The limit of a type's constant part: its zero value is allocated completely (64 MiB).
MAX_FIXED_BYTES: Final = 1 << 26

# The limit of objects in a zero value: fixed arrays of structs multiply, even in a short text.
MAX_ZERO_ELEMENTS: Final = 1 << 20

# The limit of elements without content in an array: they have no bytes, so the length of a payload does not
# limit them. Four bytes could mean four billion objects.
MAX_EMPTY_ELEMENTS: Final = 256


class DefinitionSource(Protocol):
    """The source of message definitions, such as `msgdef.registry.Registry`."""

    def message(self, name: str) -> MessageSpec:
        """Return the definition of `package/Name`. Raises UnknownTypeError, DefinitionError."""


class Number(msgspec.Struct, frozen=True, eq=False):
    """A bool, integer or float; `code` is its `struct` format."""

    name: str
    code: str
    fixed_size_bytes: int
    zero_elements: int = 1


class Stamp(msgspec.Struct, frozen=True, eq=False):
    """A time (two uint32) or duration (two int32); `code` is its `struct` format."""

    name: str
    code: str
    fixed_size_bytes: int = 8
    zero_elements: int = 1


class Text(msgspec.Struct, frozen=True, eq=False):
    """A string: a uint32 length and that many bytes, so never of constant size."""

    name: str = "string"
    fixed_size_bytes: None = None
    zero_elements: int = 1


class Array(msgspec.Struct, frozen=True, eq=False):
    """An array; `length` is None if a uint32 count precedes the elements.

    `zero_elements` counts the objects of the zero value, `fixed_size_bytes` is None if the size varies.
    """

    element: Number | Stamp | Text | Struct
    length: int | None
    fixed_size_bytes: int | None
    zero_elements: int

    @property
    def name(self) -> str:
        """The type as a definition writes it, such as `float64[9]`."""
        return f"{self.element.name}[{'' if self.length is None else self.length}]"

    @property
    def is_bytes(self) -> bool:
        """Whether the array's value is a `bytes`: uint8[] and char[]."""
        return self.element.name in _BYTE_NAMES

    @property
    def max_count(self) -> int | None:
        """The limit of elements of a variable array, None if its bytes limit it."""
        if self.element.fixed_size_bytes == 0:
            return max(1, MAX_EMPTY_ELEMENTS // self.element.zero_elements)
        return None


class Member(msgspec.Struct, frozen=True, eq=False):
    """One field of a struct; `type` is spelled as in the definition."""

    name: str
    type: FieldType
    node: Node


class Struct(msgspec.Struct, frozen=True, eq=False):
    """A message type; `depth` is 1 if no field is a struct."""

    name: str
    members: tuple[Member, ...]
    constants: tuple[Constant, ...]
    depth: int
    fixed_size_bytes: int | None
    zero_elements: int


Node: TypeAlias = Number | Stamp | Text | Array | Struct

_BYTE_NAMES: Final = frozenset({"uint8", "char"})

SCALARS: Final[dict[str, Number | Stamp | Text]] = {
    "bool": Number("bool", "?", 1),
    "int8": Number("int8", "b", 1),
    "byte": Number("byte", "b", 1),
    "uint8": Number("uint8", "B", 1),
    "char": Number("char", "B", 1),
    "int16": Number("int16", "h", 2),
    "uint16": Number("uint16", "H", 2),
    "int32": Number("int32", "i", 4),
    "uint32": Number("uint32", "I", 4),
    "int64": Number("int64", "q", 8),
    "uint64": Number("uint64", "Q", 8),
    "float32": Number("float32", "f", 4),
    "float64": Number("float64", "d", 8),
    "string": Text(),
    "time": Stamp("time", "II"),
    "duration": Stamp("duration", "ii"),
}


class TypeTrees:
    """Resolves message types to trees, each once."""

    def __init__(self, source: DefinitionSource) -> None:
        self._source = source
        self._structs: dict[str, Struct] = {}

    def struct(self, name: str) -> Struct:
        """Return the tree of `package/Name`. Raises UnknownTypeError, DefinitionError."""
        return self._struct(name, ())

    def _struct(self, name: str, within: tuple[str, ...]) -> Struct:
        struct = self._structs.get(name)
        return struct if struct is not None else self._resolve(name, self._source.message(name), within)

    def _resolve(self, name: str, spec: MessageSpec, within: tuple[str, ...]) -> Struct:
        if name in within:
            cycle = " -> ".join((*within[within.index(name) :], name))
            raise DefinitionError(
                f"{name} contains itself ({cycle}), so its messages would be infinitely long; "
                "remove one of these fields"
            )
        if len(within) >= MAX_DEPTH:
            raise DefinitionError(f"{within[0]} nests types more than {MAX_DEPTH} levels deep; flatten it")
        within = (*within, name)
        members = tuple(
            Member(field.name, field.type, self._node(field.type, within)) for field in spec.fields
        )
        nodes = [member.node for member in members]
        struct = Struct(
            name,
            members,
            spec.constants,
            1 + max((_depth(node) for node in nodes), default=0),
            _total_size(node.fixed_size_bytes for node in nodes),
            1 + sum(node.zero_elements for node in nodes),
        )
        _check_size(name, struct)
        if struct.depth > MAX_DEPTH:
            raise DefinitionError(f"{name} nests types more than {MAX_DEPTH} levels deep; flatten it")
        self._structs[name] = struct
        return struct

    def _node(self, field_type: FieldType, within: tuple[str, ...]) -> Node:
        element = SCALARS.get(field_type.base) or self._struct(field_type.base, within)
        if not field_type.is_array:
            return element
        array = _array(element, field_type.length)
        _check_size(f"the {field_type} in {within[-1]}", array)
        return array


def _array(element: Number | Stamp | Text | Struct, length: int | None) -> Array:
    if length is None:
        return Array(element, None, None, 1)
    size = element.fixed_size_bytes
    fixed_size_bytes = 0 if length == 0 else None if size is None else length * size
    zero_elements = 1 if element.name in _BYTE_NAMES else 1 + length * element.zero_elements
    return Array(element, length, fixed_size_bytes, zero_elements)


def _depth(node: Node) -> int:
    struct = node.element if isinstance(node, Array) else node
    return struct.depth if isinstance(struct, Struct) else 0


def _total_size(sizes: Iterable[int | None]) -> int | None:
    total = 0
    for size in sizes:
        if size is None:
            return None
        total += size
    return total


def _check_size(owner: str, node: Array | Struct) -> None:
    if (node.fixed_size_bytes or 0) > MAX_FIXED_BYTES:
        raise DefinitionError(
            f"{owner} needs at least {node.fixed_size_bytes} bytes, more than the limit of {MAX_FIXED_BYTES};"
            " shorten its arrays"
        )
    limit = MAX_EMPTY_ELEMENTS if node.fixed_size_bytes == 0 else MAX_ZERO_ELEMENTS
    if node.zero_elements > limit + 1:
        raise DefinitionError(
            f"{owner} has {node.zero_elements} parts, more than the limit of {limit}; shorten its arrays"
        )
