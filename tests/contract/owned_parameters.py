"""The graph in memory with parameters as ROS 2 has them: each belongs to a node, and services reach it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Graph, ParamValue, Watch
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.services import ParameterServices
from rostether.ros2.parameters.store import ParameterStore


class OwnedParametersNetwork:
    """Makes nodes of one network; `join` is a `JoinGraph`."""

    def __init__(self) -> None:
        self.network = MemoryNetwork()

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        """Join, with the parameters of this node."""
        graph = await self.network.join(node_name, namespace=namespace, remappings=remappings)
        store = ParameterStore()
        await ParameterServices(store, graph).open()
        return _OwnedParametersGraph(graph, GraphParameters(store, graph))


class _OwnedParametersGraph:
    def __init__(self, graph: MemoryGraph, parameters: GraphParameters) -> None:
        self._parameters = parameters
        self.node_name = graph.node_name
        self.resolve = graph.resolve
        self.advertise = graph.advertise
        self.subscribe = graph.subscribe
        self.advertise_service = graph.advertise_service
        self.call_service = graph.call_service
        self.log = graph.log
        self.now = graph.now
        self.snapshot = graph.snapshot
        self.changes = graph.changes
        self.close = graph.close
        self.wait_closed = graph.wait_closed

    async def get_param(self, name: str) -> ParamValue:
        return await self._parameters.get(self.resolve(name))

    async def set_param(self, name: str, value: ParamValue) -> None:
        await self._parameters.set(self.resolve(name), value)

    async def delete_param(self, name: str) -> None:
        await self._parameters.delete(self.resolve(name))

    async def has_param(self, name: str) -> bool:
        return await self._parameters.has(self.resolve(name))

    async def search_param(self, name: str) -> str | None:
        return await self._parameters.search(name, self.resolve)

    async def list_params(self) -> list[str]:
        return await self._parameters.names()

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> Watch:
        return await self._parameters.watch(self.resolve(name), on_change)
