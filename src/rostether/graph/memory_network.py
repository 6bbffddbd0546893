"""A ROS graph inside one process, without sockets: tests and previews join it instead of a master."""

from __future__ import annotations

from collections.abc import Mapping

from rostether.graph.memory_graph import MemoryGraph
from rostether.graph.memory_state import MemoryState
from rostether.graph.ports import NAME_TAKEN
from rostether.names.graph_name import join, validate_name


class MemoryNetwork(MemoryState):
    """One in-memory graph; `join` is a `JoinGraph`."""

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> MemoryGraph:
        """Join as `node_name`; a node that has the name leaves. Raises InvalidNameError."""
        full_name = join(namespace, validate_name(node_name))
        if before := self.nodes.get(full_name):
            await before.close(NAME_TAKEN)
        graph = MemoryGraph(self, full_name, namespace, remappings or {})
        self.nodes[full_name] = graph
        self.notify()
        return graph
