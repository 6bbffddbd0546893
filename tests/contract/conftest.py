"""Every test of this folder runs against every implementation of the graph port."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping

import pytest
import pytest_asyncio

from contract.capabilities import Capabilities
from contract.implementations import IMPLEMENTATIONS, Implementation
from rostether.graph.ports import Graph, JoinGraph


class _ClosingJoin:
    """Joins the graph; at the end of the test, all nodes leave."""

    def __init__(self, join: JoinGraph) -> None:
        self._join = join
        self.graphs: list[Graph] = []

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        graph = await self._join(node_name, namespace=namespace, remappings=remappings)
        self.graphs.append(graph)
        return graph


@pytest.fixture(params=list(IMPLEMENTATIONS))
def implementation(request: pytest.FixtureRequest) -> Implementation:
    """Each implementation in turn."""
    return IMPLEMENTATIONS[request.param]


@pytest.fixture
def capabilities(implementation: Implementation) -> Capabilities:
    """What the implementation under test can do."""
    return implementation.capabilities


@pytest_asyncio.fixture
async def join(implementation: Implementation) -> AsyncIterator[JoinGraph]:
    """Join a fresh, empty graph."""
    async with implementation.open() as join:
        closing_join = _ClosingJoin(join)
        try:
            yield closing_join
        finally:
            for graph in closing_join.graphs:
                await graph.close()
