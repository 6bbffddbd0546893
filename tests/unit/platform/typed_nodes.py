"""Nodes on a graph in memory, and what the platform's tests collect from them."""

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
    """Keeps what a node reports."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, level: Level, text: str) -> None:
        """Be a `report`."""
        self.texts.append(text)
