"""The parameter methods of the graph port, the same for every ROS 2 graph."""

from __future__ import annotations

from collections.abc import Callable

from rostether.graph.node_membership import NodeMembership
from rostether.graph.ports import ParamValue
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.watches import Ros2ParameterWatch


class Ros2Membership(NodeMembership):
    """The base class of a ROS 2 graph, where parameters belong to nodes and are accessed by services."""

    _parameters: GraphParameters

    async def get_param(self, name: str) -> ParamValue:
        """Return a parameter's value. Raises UnknownNameError."""
        return await self._parameters.get(self.resolve(name))

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter; a mapping replaces the whole tree below it."""
        await self._parameters.set(self.resolve(name), value)

    async def delete_param(self, name: str) -> None:
        """Delete a parameter. Raises UnknownNameError."""
        await self._parameters.delete(self.resolve(name))

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set."""
        return await self._parameters.has(self.resolve(name))

    async def search_param(self, name: str) -> str | None:
        """Find a parameter; a relative name is searched only on this node."""
        return await self._parameters.search(name, self.resolve)

    async def list_params(self) -> list[str]:
        """Return the full names of the parameters of all nodes, sorted."""
        return await self._parameters.names()

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> Ros2ParameterWatch:
        """Call back with the value now and whenever it has changed; None means it is unset."""
        self._check_open()
        return await self._parameters.watch(self.resolve(name), on_change)
