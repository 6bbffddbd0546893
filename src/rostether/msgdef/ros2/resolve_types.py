"""Which other messages a ROS 2 message is made of, within safe bounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.msgdef.resolve_types import MAX_DEPTH, MAX_FIXED_VALUES
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Field, Ros2Message

Lookup: TypeAlias = Callable[[str], Ros2Message]

_BYTES_A_VALUE = 256  # a fixed array of bytes is one value in memory, so it counts by size only


def dependencies(message: Ros2Message, lookup: Lookup) -> list[Ros2Message]:
    """Return all messages below `message`, each once, in the order of first use, depth first.

    `lookup` maps `package/msg/Name` to its definition. Raises UnknownTypeError naming the field that needs
    the missing type, DefinitionError for a type that holds itself, nests too deep or is too large.
    """
    walk = _Walk(lookup)
    walk.visit(message, (message.full_name,))
    return list(walk.found.values())


class _Walk:
    def __init__(self, lookup: Lookup) -> None:
        self.found: dict[str, Ros2Message] = {}
        self._lookup = lookup
        self._values: dict[str, int] = {}

    def visit(self, message: Ros2Message, path: tuple[str, ...]) -> int:
        """Find everything below `message` and return how many values each of its messages holds."""
        if len(path) > MAX_DEPTH:
            raise DefinitionError(f"messages nest deeper than {MAX_DEPTH}: {' -> '.join(path)}", file=path[0])
        total = 0
        for field in message.fields:
            if field.type.base in PRIMITIVE_TYPES:
                total += _primitive_values(field)
                continue
            each = self._visit_field(message, field, path)
            if not field.type.is_array:
                total += each
            elif field.type.length is not None:
                total += each * field.type.length
        if total > MAX_FIXED_VALUES:
            raise DefinitionError(
                f"every message would hold {total} values, more than {MAX_FIXED_VALUES}; use arrays of"
                " variable length",
                file=message.full_name,
            )
        self._values[message.full_name] = total
        return total

    def _visit_field(self, message: Ros2Message, field: Ros2Field, path: tuple[str, ...]) -> int:
        name = field.type.base
        if name in path:
            cycle = " -> ".join((*path[path.index(name) :], name))
            raise DefinitionError(f"a message cannot hold itself: {cycle}", file=message.full_name)
        if name in self._values:
            return self._values[name]
        try:
            nested = self._lookup(name)
        except UnknownTypeError as error:
            raise UnknownTypeError(f"{message.full_name}, field {field.name!r}: {error}") from error
        self.found[name] = nested
        return self.visit(nested, (*path, name))


def _primitive_values(field: Ros2Field) -> int:
    length = field.type.length
    if not field.type.is_array or length is None:
        return 1
    return 1 + length // _BYTES_A_VALUE if field.type.base in ("uint8", "char", "byte") else length
