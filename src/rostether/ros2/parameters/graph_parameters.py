"""The graph port's parameters on ROS 2: full names, trees and watches over parameters that nodes own."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping

from rostether.errors import GraphError, SerializationError, UnknownNameError
from rostether.graph.ports import Graph, ParamValue
from rostether.ros2.parameters.client import LIST_SERVICE, ParameterClient
from rostether.ros2.parameters.parameter_name import ParameterPath, full_name, locate, name_parts
from rostether.ros2.parameters.store import OwnParameters
from rostether.ros2.parameters.typed_value import NOT_SET, TypedValue, flatten
from rostether.ros2.parameters.watches import Ros2ParameterWatch, Ros2ParameterWatches


class GraphParameters:
    """Implements the parameter methods of `graph.ports.Graph`; names are fully resolved.

    A method that needs another node raises the errors of `ParameterClient`.
    """

    def __init__(self, own: OwnParameters, graph: Graph) -> None:
        self._own = own
        self._graph = graph
        self._node = graph.node_name
        self._client = ParameterClient(graph)
        self._watches = Ros2ParameterWatches(own, graph, self._value_or_none)

    async def get(self, name: str) -> ParamValue:
        """Return a value or tree.

        Raises UnknownNameError if it is not set. If it belongs to this node, it is then declared, so that
        other nodes can set it.
        """
        parameter = await self._locate(name)
        values = await self._values(parameter)
        if not values:
            if parameter.node == self._node:
                self._own.declare(parameter.path)
            raise UnknownNameError(f"parameter {name} is not set")
        return _tree(parameter, values)

    async def set(self, name: str, value: ParamValue) -> None:
        """Set a value; a mapping replaces the whole tree below the name.

        Raises SerializationError for values that ROS 2 does not support, GraphError if the node refuses.
        """
        parameter = await self._locate(name)
        values = flatten(parameter.path, value)
        if "" in values:
            raise GraphError(f"{name} is a node; give the name of a parameter below it, or a mapping")
        before = await self._names_within(parameter)
        gone = {each: NOT_SET for each in before if each not in values}
        await self._apply(parameter.node, {**gone, **values})

    async def delete(self, name: str) -> None:
        """Delete a value or tree. Raises UnknownNameError, GraphError if the node refuses."""
        parameter = await self._locate(name)
        values = await self._values(parameter)
        if not values:
            raise UnknownNameError(f"parameter {name} is not set")
        await self._apply(parameter.node, dict.fromkeys(values, NOT_SET))

    async def has(self, name: str) -> bool:
        """Return whether a parameter, or one below it, is set."""
        return bool(await self._values(await self._locate(name)))

    async def search(self, name: str, resolve: Callable[[str], str]) -> str | None:
        """Find a parameter; a relative name is searched only on this node.

        As in ROS 1, only the first part of the name must exist.
        """
        if name.startswith(("/", "~")):
            resolved = resolve(name)
            return resolved if await self.has(resolved) else None
        path = ParameterPath(self._node, name_parts(name)[0] if name_parts(name) else "")
        is_there = any(map(path.holds, self._own.names()))
        return full_name(self._node, name) if is_there else None

    async def names(self) -> list[str]:
        """Return the full names of the parameters of all nodes that answer, sorted."""
        services = (await self._graph.snapshot()).services
        suffix = f"/{LIST_SERVICE}"
        others = {name.removesuffix(suffix) for name in services if name.endswith(suffix)} - {self._node}
        found = await asyncio.gather(*(self._names_of(node) for node in sorted(others)))
        own = [full_name(self._node, name) for name in self._own.names()]
        return sorted([*own, *(name for names in found for name in names)])

    async def watch(self, name: str, on_change: Callable[[ParamValue], None]) -> Ros2ParameterWatch:
        """Call back with the value now and after every change; None means it is unset. Raises GraphError."""
        return await self._watches.add(name, on_change)

    async def close(self) -> None:
        """End all watches."""
        await self._watches.close()

    async def _locate(self, name: str) -> ParameterPath:
        # A name below this node may be below another node with a longer name.
        return locate(name, (await self._graph.snapshot()).nodes, self._node)

    async def _value_or_none(self, name: str) -> ParamValue:
        parameter = await self._locate(name)
        values = await self._values(parameter)
        return _tree(parameter, values) if values else None

    async def _values(self, parameter: ParameterPath) -> dict[str, TypedValue]:
        if parameter.node == self._node:
            return {name: self._own.get(name) for name in self._own.names() if parameter.holds(name)}
        if parameter.path and (found := await self._client.get(parameter.node, [parameter.path])):
            return found
        names = await self._names_within(parameter)
        return await self._client.get(parameter.node, names) if names else {}

    async def _names_within(self, parameter: ParameterPath) -> list[str]:
        names = (
            self._own.names() if parameter.node == self._node else await self._client.names(parameter.node)
        )
        return [name for name in names if parameter.holds(name)]

    async def _names_of(self, node: str) -> list[str]:
        try:
            names = await self._client.names(node)
            values = await self._client.get(node, names) if names else {}
        except (GraphError, SerializationError):
            # This node has left, hangs, or has no parameters; the parameters of the other nodes are listed.
            return []
        return [full_name(node, name) for name in values]

    async def _apply(self, node: str, values: Mapping[str, TypedValue]) -> None:
        if not values:
            return
        if node == self._node:
            self._own.apply(values)
        else:
            await self._client.set(node, values)


def _tree(parameter: ParameterPath, values: Mapping[str, TypedValue]) -> ParamValue:
    depth = len(name_parts(parameter.path))
    root: dict[str, ParamValue] = {}
    # The deepest names are last.
    for name, value in sorted(values.items(), key=lambda item: len(name_parts(item[0]))):
        parts = name_parts(name)[depth:]
        if not parts:
            # ROS 2 may have both `a` and `a.b`; a request for `a` returns only that parameter.
            return value.value
        tree = root
        for part in parts[:-1]:
            child = tree.setdefault(part, {})
            if not isinstance(child, dict):
                break
            tree = child
        else:
            tree[parts[-1]] = value.value
    return root
