"""Every test of this folder runs against every implementation of the graph port."""

from __future__ import annotations

import functools
from collections.abc import AsyncIterator, Mapping

import pytest
import pytest_asyncio

from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph, JoinGraph
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1


class _Closing:
    """Joins, and leaves with every node at the end of the test."""

    def __init__(self, join: JoinGraph) -> None:
        self._join = join
        self.graphs: list[Graph] = []

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        graph = await self._join(node_name, namespace=namespace, remappings=remappings)
        self.graphs.append(graph)
        return graph


@pytest_asyncio.fixture(params=["memory", "ros1"])
async def join(request: pytest.FixtureRequest) -> AsyncIterator[JoinGraph]:
    """Join a fresh, empty graph."""
    if request.param == "memory":
        closing = _Closing(MemoryNetwork().join)
        yield closing
        for graph in closing.graphs:
            await graph.close()
        return
    master = await MasterServer.start(port=0)
    closing = _Closing(
        functools.partial(join_ros1, master_uri=master.uri, environment=RosEnvironment.read({}))
    )
    yield closing
    for graph in closing.graphs:
        await graph.close()
    await master.close()
