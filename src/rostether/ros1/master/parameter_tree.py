"""The Parameter Server's tree, without any I/O.

Names are resolved (`/a/b`); a dict is a namespace, and setting one replaces everything below it. A node that
watches a name receives every change at, above and below it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rostether.errors import GraphError, UnknownNameError
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.xmlrpc.values import MAX_NESTING, XmlRpcValue

# Answers and notices wrap a value once or twice more; XML-RPC documents end at MAX_NESTING.
MAX_DEPTH = MAX_NESTING - 10
# Far more than any node has; the names of one namespace are copied before they are sent.
MAX_ENTRIES = 262_144
# What a value takes in memory beside its text, roughly.
_BYTES_PER_VALUE = 64


@dataclass(frozen=True, slots=True)
class Update:
    """For watchers of `watched`: `key` (with a trailing slash) is now `value`; `{}` means unset."""

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
        """Return a value or a whole namespace; do not change it. Raises UnknownNameError."""
        return self._find(name)

    def has(self, name: str) -> bool:
        """Tell whether a parameter or namespace is set."""
        try:
            self._find(name)
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
        if len(space) >= MAX_ENTRIES and key not in space:
            raise GraphError(f"a namespace holds at most {MAX_ENTRIES} parameters: use several namespaces")
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


def _weigh(value: XmlRpcValue, nesting: int) -> int:
    if value is None:
        raise GraphError("a parameter cannot be nil: delete it instead")
    if isinstance(value, (str, bytes)):
        return _BYTES_PER_VALUE + len(value)
    if not isinstance(value, (dict, list)):
        return _BYTES_PER_VALUE
    if nesting <= 0:
        raise GraphError(f"parameters cannot be nested deeper than {MAX_DEPTH} levels: flatten them")
    weight = _BYTES_PER_VALUE * (1 + len(value))
    if isinstance(value, dict):
        weight += sum(map(len, value))
        value = list(value.values())
    # Without a call for each scalar: this runs on the event loop, for 262,144 values.
    for item in value:
        kind = type(item)
        if kind is str or kind is bytes:
            weight += len(item)  # type: ignore[arg-type]
        elif kind is not int and kind is not float and kind is not bool:
            weight += _weigh(item, nesting - 1) - _BYTES_PER_VALUE
    return weight
