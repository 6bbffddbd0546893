"""Parameters of the in-memory graph: one tree, shared by its nodes, with watches."""

from __future__ import annotations

import asyncio
import copy
from collections.abc import Callable, Iterator

from rostether.errors import UnknownNameError
from rostether.graph.parameter_watch import ParameterWatch
from rostether.graph.ports import ParamValue
from rostether.names.graph_name import is_in_namespace


class MemoryParameters:
    """A tree of parameters; names are fully qualified, and values are copied in and out."""

    def __init__(self) -> None:
        self._root: dict[str, ParamValue] = {}
        self._watches: list[ParameterWatch] = []

    def get(self, name: str) -> ParamValue:
        """Return a value or a whole tree. Raises UnknownNameError."""
        value: ParamValue = self._root
        for part in _parts(name):
            if not isinstance(value, dict) or part not in value:
                raise UnknownNameError(f"parameter {name} is not set")
            value = value[part]
        return copy.deepcopy(value)

    def get_or_none(self, name: str) -> ParamValue:
        """Return a value, or None if there is none."""
        try:
            return self.get(name)
        except UnknownNameError:
            return None

    def set(self, name: str, value: ParamValue) -> None:
        """Set a value; a mapping replaces the whole tree below the name.

        Raises UnknownNameError if the name is `/` and the value is not a mapping.
        """
        value = copy.deepcopy(value)
        parts = _parts(name)
        if parts:
            tree = self._root
            for part in parts[:-1]:
                child = tree.get(part)
                if not isinstance(child, dict):
                    child = tree[part] = {}
                tree = child
            tree[parts[-1]] = value
        elif isinstance(value, dict):
            self._root = value
        else:
            raise UnknownNameError("the root of all parameters can only be set to a mapping; give a mapping")
        self._changed(name)

    def delete(self, name: str) -> None:
        """Delete a value or tree. Raises UnknownNameError."""
        self.get(name)
        parts = _parts(name)
        if not parts:
            self._root = {}
        else:
            tree = self._root
            for part in parts[:-1]:
                child = tree[part]
                assert isinstance(child, dict)
                tree = child
            del tree[parts[-1]]
        self._changed(name)

    def names(self) -> list[str]:
        """Return the names of all values, sorted."""
        return sorted(_leaves("", self._root))

    def watch(self, name: str, on_change: Callable[[ParamValue], None]) -> ParameterWatch:
        """Call back now and whenever the value of `name` has changed."""
        watch = ParameterWatch(name, on_change, self._forget)
        self._watches.append(watch)
        watch.report(self.get_or_none(name))
        return watch

    async def _forget(self, watch: ParameterWatch) -> None:
        self._watches.remove(watch)

    def _changed(self, name: str) -> None:
        for watch in self._watches:
            if is_in_namespace(watch.name, name) or is_in_namespace(name, watch.name):
                asyncio.get_running_loop().call_soon(self._report_value, watch)

    def _report_value(self, watch: ParameterWatch) -> None:
        watch.report(self.get_or_none(watch.name))


def _parts(name: str) -> list[str]:
    return [part for part in name.split("/") if part]


def _leaves(prefix: str, tree: dict[str, ParamValue]) -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _leaves(f"{prefix}/{key}", value)
        else:
            yield f"{prefix}/{key}"
