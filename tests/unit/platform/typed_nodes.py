"""Nodes on a graph in memory, and a collector of their reports."""

from __future__ import annotations

from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

STORE = TypeStore(Registry())


async def typed_nodes(*names: str) -> tuple[MemoryNetwork, list[TypedGraph]]:
    """Return a network and one node for each name."""
    network = MemoryNetwork()
    return network, [TypedGraph(await network.join(name), STORE) for name in names]


class Lines:
    """Collects the reports of a node."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, level: Level, text: str) -> None:
        """Store a line, as `report`."""
        self.texts.append(text)
