"""Finds the ROS 2 distribution."""

from __future__ import annotations

from collections.abc import Mapping

from rostether.graph.ports import Graph
from rostether.msgdef.ros2.definition_files import BUNDLED_DISTRO, named_distro
from rostether.ros2.endpoint_info import Ros2Graph


async def find_distribution(graph: Graph, environ: Mapping[str, str]) -> str:
    """Return the distribution of a ROS 2 graph: ROS_DISTRO, else the graph's, else the default."""
    shown = await graph.distribution() if isinstance(graph, Ros2Graph) else ""
    return named_distro(environ) or shown or BUNDLED_DISTRO
