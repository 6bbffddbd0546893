"""The graph of a command line, ROS 1 or ROS 2, with messages as ROS 1 defines them."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions, Middleware
from rostether.cli.access.ros1_access import joined, read_environment, type_store
from rostether.mechanisms.block_end import closed_at_end
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph


@asynccontextmanager
async def joined_either(graph: GraphOptions, *, purpose: str) -> AsyncIterator[tuple[TypedGraph, str]]:
    """Join the graph; yield it with its name for users.

    `purpose` is the beginning of a ROS 1 node's name; a ROS 2 node is hidden. Raises UsageError, ConfigError,
    InvalidNameError, GraphError.
    """
    if graph.ros2 is None:
        async with joined(graph, purpose=purpose) as node:
            yield node, read_environment(graph).master_uri
        return
    from rostether.cli.access.ros2_access import ros2_access
    from rostether.cli.access.ros2_tool_node import HIDDEN_NAME, warn_without_router
    from rostether.graph.typed_graph import TypedGraph

    async with ros2_access(graph.ros2, reach=ZenohReach(RouterChoice.NEVER)) as access:
        if graph.ros2 is Middleware.ZENOH:
            await warn_without_router()
        raw = await access.join(graph.node_name(HIDDEN_NAME))
        async with closed_at_end(raw):
            yield TypedGraph(raw, type_store()), "the ROS 2 graph"
