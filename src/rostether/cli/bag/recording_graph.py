"""The graph to record from or to play to: ROS 1, ROS 2, or both."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions, ZenohReach
from rostether.cli.access.middleware import Middleware
from rostether.cli.access.ros1_access import joined, read_environment
from rostether.cli.access.ros2_access import ros2_access

if TYPE_CHECKING:
    from rostether.graph.ports import Graph
    from rostether.recording.recorded import Ros2Origin
    from rostether.ros2.types.type_support import Ros2Types


@dataclass(frozen=True, slots=True)
class RecordingGraph:
    """This command's node; `types` are its known ROS 2 types, None if it is on ROS 1 only."""

    raw: Graph
    types: Ros2Types | None


@asynccontextmanager
async def recording_graph(
    graph: GraphOptions,
    purpose: str,
    *,
    is_native: bool = False,
    origins: Iterable[Ros2Origin] = (),
    msg_paths: Iterable[Path] = (),
) -> AsyncIterator[RecordingGraph]:
    """Join as a node during the block. Raises GraphError, ConfigError.

    On ROS 2 alone, messages come and go natively, in ROS 2's own fields, if `is_native`; `origins` are types
    of recordings, which need not be known here.
    """
    from rostether.mechanisms.anonymous import anonymous_name

    if graph.ros2 is None:
        async with joined(graph, purpose=purpose) as node:
            yield RecordingGraph(node.raw, None)
        return
    paths = tuple(msg_paths)
    types = recording_types(origins, paths) if is_native and graph.is_ros2_alone else None
    # A recorder must not become the router that other programs need.
    reach = ZenohReach(graph.zenoh.connect, graph.zenoh.listen, "never")
    name = graph.arguments.get("__name") or anonymous_name(purpose)
    async with ros2_access(graph.ros2, paths, reach=reach, types=types) as access:
        if graph.ros2 is Middleware.ZENOH and not (reach.connect or reach.listen):
            from rostether.cli.access.ros2_tool_node import warn_without_router

            await warn_without_router()
        join = access.join
        if graph.uses_ros1:
            from rostether.cli.access.ros1_access import joining_ros1
            from rostether.graph.joint_join import JointJoin

            join = JointJoin([joining_ros1(read_environment(graph)), join])
        raw = await join(name, namespace=graph.arguments.get("__ns", "/"))
        try:
            yield RecordingGraph(raw, access.types)
        finally:
            await raw.close()


def recording_types(origins: Iterable[Ros2Origin], msg_paths: tuple[Path, ...] = ()) -> Ros2Types:
    """Return the types of ROS 2 here and in recordings, in their own fields; unknown ones stay CDR."""
    from rostether.msgdef.registry import Registry
    from rostether.msgdef.ros2.definitions import Ros2Definitions
    from rostether.recording.ros2_types import RecordedDefinitions
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.ros2.types.undefined_types import UndefinedTypes

    definitions = RecordedDefinitions(Ros2Definitions.from_environment(msg_paths))
    for origin in origins:
        definitions.learn(origin)
    return UndefinedTypes(NativeRegistry(definitions, Registry.from_environment(msg_paths)))
