"""The Parameter Server's tree, without any I/O.

Names are resolved (`/a/b`); a dict is a namespace, and setting one replaces everything below it. Whoever
watches a name hears of every change at, above and below it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rostether.errors import GraphError, UnknownNameError
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.xmlrpc.values import MAX_NESTING, XmlRpcValue

# Answers and notices wrap a value once or twice more; XML-RPC documents end at MAX_NESTING.
MAX_DEPTH = MAX_NESTING - 10
# What a value takes in memory beside its text, roughly.
_BYTES_PER_VALUE = 64


@dataclass(frozen=True, slots=True)
class Update:
    """Who watches `watched` hears that `key` (with a trailing slash) is now `value`; `{}` means unset."""

    watched: str
    key: str
    value: XmlRpcValue
    is_own_change: bool


def watch_key(name: str) -> str:
    """Return the form of a resolved name under which watchers are kept: with a trailing slash."""
    return "/" + "".join(f"{part}/" for part in _parts(name))


def _parts(name: str) -> list[str]:
    return [part for part in name.split("/") if part]


class ParameterTree:
    """The parameters of one master."""

    def __init__(self, limits: GraphLimits = DEFAULT_GRAPH_LIMITS) -> None:
        self._limits = limits
        self._root: dict[str, XmlRpcValue] = {}
        self._bytes = _BYTES_PER_VALUE

    def get(self, name: str) -> XmlRpcValue:
        """Return a copy of a value or of a whole namespace. Raises UnknownNameError."""
        return _copy(self._find(name))

    def has(self, name: str) -> bool:
        """Tell whether a parameter or namespace is set."""
        try:
            self._find(name)
        except UnknownNameError:
            return False
        return True

    def names(self) -> list[str]:
        """Return the full names of all parameters."""
        return [name for name, value in _walk("/", self._root) if not isinstance(value, dict)]

    def set(self, name: str, value: XmlRpcValue) -> None:
        """Set a parameter; values on the way become namespaces. Raises GraphError for what cannot be set."""
        parts = _parts(name)
        if not parts and not isinstance(value, dict):
            raise GraphError("cannot set root of parameter tree to non-dictionary")
        if len(parts) > MAX_DEPTH:
            raise GraphError(f"parameters cannot be nested deeper than {MAX_DEPTH} levels: flatten them")
        added = _weigh(value, MAX_DEPTH - len(parts))
        largest, most = self._limits.parameter_bytes, self._limits.parameters_bytes
        if added > largest:
            raise GraphError(f"{name} would take more than {largest} bytes: raise --limit parameter-bytes")
        if self._bytes + added + len(name) + _BYTES_PER_VALUE * len(parts) > most:
            raise GraphError(
                f"the parameters would take more than {most} bytes: delete some, or raise "
                "--limit parameters-bytes"
            )
        if isinstance(value, dict) and not parts:
            self._root, self._bytes = value, added
            return
        space = self._root
        for part in parts[:-1]:
            below = space.get(part)
            if not isinstance(below, dict):
                below = {}
                self._put(space, part, below, _BYTES_PER_VALUE)
            space = below
        self._put(space, parts[-1], value, added)

    def _put(self, space: dict[str, XmlRpcValue], key: str, value: XmlRpcValue, weight: int) -> None:
        self._bytes += weight + len(key)
        if key in space:
            self._bytes -= _weigh(space[key], MAX_DEPTH) + len(key)
        space[key] = value

    def delete(self, name: str) -> None:
        """Delete a parameter or namespace. Raises UnknownNameError, for the root too."""
        parts = _parts(name)
        space = self._find("/".join(parts[:-1])) if parts else None
        if not isinstance(space, dict) or parts[-1] not in space:
            raise UnknownNameError(f"parameter {name} is not set")
        self._bytes -= _weigh(space.pop(parts[-1]), MAX_DEPTH) + len(parts[-1])

    def search(self, namespace: str, key: str) -> str | None:
        """Return the full name of `key` in the nearest namespace, upward, that has its first part.

        Only the first part must be there: a search for `robot/arm` stops at the first `robot`.
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

    def _find(self, name: str) -> XmlRpcValue:
        value: XmlRpcValue = self._root
        for part in _parts(name):
            if not isinstance(value, dict) or part not in value:
                raise UnknownNameError(f"parameter {name} is not set")
            value = value[part]
        return value


def updates(watched: Iterable[str], name: str, value: XmlRpcValue) -> list[Update]:
    """Return what the watchers of each watched key are told when `name` becomes `value`, `{}` for deleted.

    Watchers of the name and above hear of the change itself; those below hear of their own new value. The
    deepest come first: who watches on several levels, and keeps a tree, has the right one in the end.
    """
    key = watch_key(name)
    found: list[Update] = []
    below: dict[str, XmlRpcValue] | None = None
    for each in watched:
        if key.startswith(each):
            found.append(Update(each, key, value, is_own_change=True))
        elif each.startswith(key):
            if below is None:
                below = {watch_key(inner): item for inner, item in _walk(key, value)}
            found.append(Update(each, each, below.get(each, {}), is_own_change=False))
    return sorted(found, key=lambda update: -len(update.key))


def _walk(prefix: str, value: XmlRpcValue) -> Iterator[tuple[str, XmlRpcValue]]:
    if isinstance(value, dict):
        for key, item in value.items():
            name = f"{prefix}{key}"
            yield name, item
            yield from _walk(f"{name}/", item)


def _copy(value: XmlRpcValue) -> XmlRpcValue:
    if isinstance(value, dict):
        return {key: _copy(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_copy(item) for item in value]
    return value


def _weigh(value: XmlRpcValue, nesting: int) -> int:
    if value is None:
        raise GraphError("a parameter cannot be nil: delete it instead")
    if isinstance(value, (str, bytes)):
        return _BYTES_PER_VALUE + len(value)
    if not isinstance(value, (dict, list)):
        return _BYTES_PER_VALUE
    if nesting <= 0:
        raise GraphError(f"parameters cannot be nested deeper than {MAX_DEPTH} levels: flatten them")
    if isinstance(value, list):
        return _BYTES_PER_VALUE + sum(_weigh(item, nesting - 1) for item in value)
    return _BYTES_PER_VALUE + sum(len(key) + _weigh(item, nesting - 1) for key, item in value.items())
