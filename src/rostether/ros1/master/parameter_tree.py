"""The Parameter Server's tree, without any I/O.

Names are resolved (`/a/b`); a dict is a namespace, and a new one replaces everything below it. A node that
watches a name receives every change of it, above it and below it.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from typing import Any, NamedTuple, cast

from msgspec import Struct

from rostether.errors import GraphError, UnknownNameError
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.long_work import run_at_once
from rostether.xmlrpc.document_reader import MAX_VALUES
from rostether.xmlrpc.values import MAX_NESTING, DateTime, XmlRpcValue

# Answers and notices add one or two levels to a value; XML-RPC documents have at most MAX_NESTING.
MAX_DEPTH = MAX_NESTING - 10
# A few more than one XML-RPC document can have; namespaces also count. Freeing all of them takes about 20 ms.
MAX_TREE_VALUES = MAX_VALUES + 1024
# The approximate memory of a value besides its text.
_BYTES_PER_VALUE = 64
# The number of values to measure in one step, which takes about a millisecond; a container is not split.
_STEP_VALUES = 4096
# After this number of changes by other clients in the meantime, an old value is measured in one step.
_MAX_INTERRUPTIONS = 3


class Update(Struct, frozen=True):
    """A change for watchers of `watched`: `key` (with a trailing slash) is now `value`; `{}` means unset."""

    watched: str
    key: str
    value: XmlRpcValue
    is_own_change: bool


class _Size(NamedTuple):
    byte_count: int
    values: int


def watch_key(name: str) -> str:
    """Return the key of a resolved name in the table of watchers: with a trailing slash."""
    return "/" + "".join(f"{part}/" for part in _parts(name))


def _parts(name: str) -> list[str]:
    return [part for part in name.split("/") if part]


class ParameterTree:
    """The parameters of one master."""

    def __init__(self, limits: GraphLimits = DEFAULT_GRAPH_LIMITS) -> None:
        self._limits = limits
        self._root: dict[str, XmlRpcValue] = {}
        self._bytes = _BYTES_PER_VALUE
        self._values = 1
        self._changes = 0

    def get(self, name: str) -> XmlRpcValue:
        """Return a value or a whole namespace; do not change it. Raises UnknownNameError."""
        value: XmlRpcValue = self._root
        for part in _parts(name):
            if not isinstance(value, dict) or part not in value:
                raise UnknownNameError(f"parameter {name} is not set")
            value = value[part]
        return value

    def has(self, name: str) -> bool:
        """Return whether a parameter or namespace is set."""
        try:
            self.get(name)
        except UnknownNameError:
            return False
        return True

    def names(self) -> Iterator[str | None]:
        """Yield the full names of all parameters, None for each namespace; the tree may change meanwhile."""
        spaces: list[tuple[str, Iterator[tuple[str, XmlRpcValue]]]] = [("/", _items(self._root))]
        while spaces:
            prefix, items = spaces[-1]
            for key, value in items:
                if isinstance(value, dict):
                    spaces.append((f"{prefix}{key}/", _items(value)))
                    yield None
                    break
                yield f"{prefix}{key}"
            else:
                spaces.pop()

    def set(self, name: str, value: XmlRpcValue) -> None:
        """Set a parameter; values above it become namespaces. Raises GraphError if it cannot be set."""
        run_at_once(self.set_steps(name, value))

    def set_steps(self, name: str, value: XmlRpcValue) -> Iterator[None]:
        """Check a large value in several steps, and set it in the last one; see `set`."""
        parts = _parts(name)
        if not parts and not isinstance(value, dict):
            raise GraphError("cannot set root of parameter tree to non-dictionary")
        if len(parts) > MAX_DEPTH:
            raise GraphError(f"parameters cannot be nested deeper than {MAX_DEPTH} levels; flatten them")
        added = yield from _measure_steps([value], MAX_DEPTH - len(parts))
        replaced = yield from self._measure_replaced_steps(parts)
        self._check_room(name, parts, added, replaced)
        self._changes += 1
        if isinstance(value, dict) and not parts:
            self._root = value
        else:
            space = self._open_space(parts[:-1])
            self._bytes += len(parts[-1]) if parts[-1] not in space else 0
            space[parts[-1]] = value
        self._bytes += added.byte_count - replaced.byte_count
        self._values += added.values - replaced.values

    def _check_room(self, name: str, parts: list[str], added: _Size, replaced: _Size) -> None:
        largest, total = self._limits.parameter_bytes, self._limits.parameters_bytes
        if added.byte_count > largest:
            raise GraphError(f"{name} would need more than {largest} bytes; raise --limit parameter-bytes")
        byte_count = self._bytes + added.byte_count - replaced.byte_count
        if byte_count + len(name) + _BYTES_PER_VALUE * len(parts) > total:
            raise GraphError(
                f"the parameters would need more than {total} bytes; delete some, or raise "
                "--limit parameters-bytes"
            )
        if self._values + added.values - replaced.values + len(parts) > MAX_TREE_VALUES:
            raise GraphError(f"a master holds at most {MAX_TREE_VALUES} parameter values; delete some")

    def _open_space(self, parts: list[str]) -> dict[str, XmlRpcValue]:
        space = self._root
        for part in parts:
            below = space.get(part)
            if not isinstance(below, dict):
                self._bytes += _BYTES_PER_VALUE + (len(part) if part not in space else 0)
                self._values += 1
                below = space[part] = {}
            space = below
        return space

    def _measure_replaced_steps(self, parts: list[str]) -> Generator[None, None, _Size]:
        """Measure the old value that a new value at `parts` replaces, or a plain value above it."""
        for _ in range(_MAX_INTERRUPTIONS):
            changes = self._changes
            size = yield from _measure_steps(self._replaced_by(parts), MAX_DEPTH)
            if changes == self._changes:
                return size
        return _measure(self._replaced_by(parts), MAX_DEPTH)

    def _replaced_by(self, parts: list[str]) -> list[XmlRpcValue]:
        value: XmlRpcValue = self._root
        for part in parts:
            if not isinstance(value, dict):
                break
            if part not in value:
                return []
            value = value[part]
        return [value]

    def delete_steps(self, name: str) -> Iterator[None]:
        """Delete a parameter or namespace in several steps. Raises UnknownNameError, for the root too."""
        parts = _parts(name)
        self._parent(name, parts)
        size = yield from self._measure_replaced_steps(parts)
        # Another client may have deleted it in the meantime.
        del self._parent(name, parts)[parts[-1]]
        self._changes += 1
        self._bytes -= size.byte_count + len(parts[-1])
        self._values -= size.values

    def _parent(self, name: str, parts: list[str]) -> dict[str, XmlRpcValue]:
        space = self.get("/".join(parts[:-1])) if parts else None
        if not isinstance(space, dict) or parts[-1] not in space:
            raise UnknownNameError(f"parameter {name} is not set")
        return space

    def search(self, namespace: str, key: str) -> str | None:
        """Return the full name of `key` in the nearest namespace, upward, that has its first part.

        Only the first part must exist: a search for `robot/arm` stops at the first `robot`.
        """
        if key.startswith("/"):
            return key if self.has(key) else None
        first = _parts(key)[0]
        spaces = _parts(namespace)
        for depth in range(len(spaces), -1, -1):
            prefix = "".join(f"/{part}" for part in spaces[:depth])
            if self.has(f"{prefix}/{first}"):
                return f"{prefix}/{key}"
        return None


def updates(watched: Iterable[str], name: str, value: XmlRpcValue) -> list[Update]:
    """Return the updates for the watchers of each watched key when `name` becomes `value`, `{}` for deleted.

    Watchers of the name and above receive the change itself; those below receive their own new value. The
    deepest keys come first, so that a node that watches several levels ends up with the right tree.
    """
    key = watch_key(name)
    found: list[Update] = []
    for each in watched:
        if key.startswith(each):
            found.append(Update(each, key, value, is_own_change=True))
        elif each.startswith(key):
            found.append(Update(each, each, _below(value, each[len(key) :]), is_own_change=False))
    return sorted(found, key=lambda update: -len(update.key))


def _below(value: XmlRpcValue, path: str) -> XmlRpcValue:
    for part in _parts(path):
        if not isinstance(value, dict) or part not in value:
            return {}
        value = value[part]
    return value


def _items(space: dict[str, XmlRpcValue]) -> Iterator[tuple[str, XmlRpcValue]]:
    return zip(list(space), list(space.values()), strict=True)


def _measure(values: list[XmlRpcValue], nesting: int) -> _Size:
    steps = _measure_steps(values, nesting)
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast(_Size, end.value)


def _measure_steps(outermost: list[XmlRpcValue], nesting: int) -> Generator[None, None, _Size]:
    """Return the size of values. Raises GraphError for nil, and for more than `nesting` levels."""
    # Level by level and without a call for each value: this runs on the event loop, for 262,144 values.
    values, byte_count, visited = 0, 0, 0
    level: list[Any] = [outermost]
    for _ in range(nesting + 1):
        inner: list[Any] = []
        for container in level:
            values += len(container)
            items = container
            if type(container) is dict:
                byte_count += len("".join(container))
                items = container.values()
            for item in items:
                kind = type(item)
                if kind is str or kind is bytes or kind is DateTime:
                    byte_count += len(item)
                elif kind is dict or kind is list:
                    if item:
                        inner.append(item)
                elif item is None:
                    raise GraphError("a parameter cannot be nil; delete it instead")
            visited += 1 + len(container)
            if visited >= _STEP_VALUES:
                visited = 0
                yield
        level = inner
        if not level:
            return _Size(byte_count + _BYTES_PER_VALUE * values, values)
    raise GraphError(f"parameters cannot be nested deeper than {MAX_DEPTH} levels; flatten them")
