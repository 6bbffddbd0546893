"""Chooses the columns of a table of messages: one for each number, text and time, or the requested ones.

Nested fields are named with dots. Short fixed-size arrays have a column for each element (`covariance[0]`);
other arrays are one column of lists. A time has two columns, in seconds (`header.stamp_s`) and
in nanoseconds (`header.stamp_ns`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from operator import attrgetter
from typing import Any

import msgspec

from rostether.errors import ConfigError, SerializationError
from rostether.serde.codec import Codec
from rostether.serde.field_path import FieldPath
from rostether.serde.type_tree import Array, Node, Stamp, Struct

# The longest array with a column for each element: a covariance has 36.
MAX_SPREAD = 64

_WHOLE = "[:]"


class Column(msgspec.Struct, frozen=True):
    """One column; `node` is the type of the values that `read` returns, inside `lists` nested lists."""

    name: str
    node: Node
    read: Callable[[Any], Any]
    lists: int = 0


def columns_of(codec: Codec, paths: Sequence[str] = ()) -> list[Column]:
    """Return the columns of a type, or of the requested fields: paths, or patterns with `*` and `?`.

    Raises ConfigError for an unknown path or pattern; the error lists the fields.
    """
    if not paths:
        return list(_below(codec.tree, "", ()))
    chosen: dict[str, Column] = {}
    for path in paths:
        for column in _chosen(codec, path.strip("./").replace("/", ".").replace("[*]", _WHOLE)):
            chosen.setdefault(column.name, column)
    return list(chosen.values())


def _chosen(codec: Codec, path: str) -> Iterator[Column]:
    if re.search(r"[*?]", path):
        found = [
            column
            for column in _below(codec.tree, "", ())
            if fnmatchcase(_without_brackets(column.name), _without_brackets(path))
            or fnmatchcase(_without_brackets(column.name), f"{_without_brackets(path)}.*")
        ]
        if not found:
            known = ", ".join(column.name for column in _below(codec.tree, "", ()))
            raise ConfigError(f"{codec.type_name} has no field like {path!r}; it has {known}")
        yield from found
        return
    field = FieldPath(codec, path.replace(".", "/"))
    node, lists = _end_of(codec.tree, path)
    yield from _spread(node, path, lambda message: _read_or_none(field, message), lists)


def _without_brackets(name: str) -> str:
    """Return a name with other characters for the brackets, which `fnmatch` would interpret."""
    return name.replace("[", "<").replace("]", ">")


def _end_of(tree: Struct, path: str) -> tuple[Node, int]:
    """Return the type at the end of an existing path, and the number of slices in the path."""
    node: Node = tree
    lists = 0
    for part in path.split("."):
        name, _, index = part.partition("[")
        assert isinstance(node, Struct)
        node = next(member.node for member in node.members if member.name == name)
        if index:
            assert isinstance(node, Array)
            node = node.element
            lists += ":" in index
    return node, lists


def _read_or_none(field: FieldPath, message: Any) -> Any:
    try:
        return field.read(message)
    except SerializationError:
        return None  # The array is shorter in this message.


def _below(struct: Struct, prefix: str, path: tuple[str, ...]) -> Iterator[Column]:
    for member in struct.members:
        below = (*path, member.name)
        yield from _spread(member.node, prefix + member.name, attrgetter(".".join(below)), 0, below)


def _spread(
    node: Node, name: str, read: Callable[[Any], Any], lists: int, path: tuple[str, ...] = ()
) -> Iterator[Column]:
    if lists:
        yield Column(name, node, read, lists)
    elif isinstance(node, Struct):
        if path:
            yield from _below(node, f"{name}.", path)
        else:
            for member in node.members:
                yield from _spread(member.node, f"{name}.{member.name}", _within(read, member.name), 0)
    elif isinstance(node, Stamp):
        yield Column(f"{name}_s", node, _within(read, "to_s", calls=True))
        yield Column(f"{name}_ns", node, _within(read, "to_ns", calls=True))
    elif (
        isinstance(node, Array)
        and node.length is not None
        and node.length <= MAX_SPREAD
        and not node.is_bytes
        and not isinstance(node.element, Struct)
    ):
        for index in range(node.length):
            yield from _spread(node.element, f"{name}[{index}]", _element(read, index), 0)
    else:
        yield Column(name, node, read)


def _within(read: Callable[[Any], Any], name: str, *, calls: bool = False) -> Callable[[Any], Any]:
    def inner(message: Any) -> Any:
        value = read(message)
        if value is None:
            return None
        found = getattr(value, name)
        return found() if calls else found

    return inner


def _element(read: Callable[[Any], Any], index: int) -> Callable[[Any], Any]:
    return lambda message: None if (value := read(message)) is None else value[index]
