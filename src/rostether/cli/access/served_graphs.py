"""Joins the graphs that boards connect to: ROS 1 (starts a master if needed), ROS 2, or both."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.ros1_access import ros1_join
from rostether.cli.access.ros2_access import ros2_access
from rostether.errors import ConfigError, GraphError, MasterUnreachableError
from rostether.graph.joint_join import JointJoin
from rostether.graph.ports import JoinGraph
from rostether.mechanisms.block_end import closed_at_end
from rostether.ros1.environment import RosEnvironment, format_uri
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node_queries import TOOL_NAME
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

if TYPE_CHECKING:
    from rostether.ros2.actions.board_graph import NativeSession
    from rostether.ros2.types.type_support import Ros2Types

# A master on loopback answers within milliseconds; a starting one gets this long before its port counts as
# used by another program.
_ANSWER_LIMIT_S = 2.0
# A user does not notice this delay after the master's start.
_POLL_S = 0.1


class ServedGraphs(Struct, frozen=True):
    """The factory of the boards' nodes, the ROS 1 environment (None without ROS 1), and lines for users.

    `types` are the ROS 2 types, None without ROS 2.
    """

    join: JoinGraph
    ros1: RosEnvironment | None
    lines: tuple[str, ...]
    types: Ros2Types | None = None


@asynccontextmanager
async def served_graphs(
    environment: RosEnvironment,
    graph: GraphOptions,
    *,
    master_port: int | None = None,
    msg_paths: Sequence[Path] = (),
) -> AsyncIterator[ServedGraphs]:
    """Join the graphs until the end of the block. Raises GraphError, ConfigError.

    `master_port` is the port of a new ROS 1 master, None for that of the environment's URI.
    """
    graph.refuse_unused()
    joins: list[JoinGraph] = []
    lines: list[str] = []
    used_environment = None
    types = None
    async with AsyncExitStack() as stack:
        if graph.uses_ros1:
            used = await stack.enter_async_context(
                used_master(environment, is_chosen=graph.master is not None, port=master_port)
            )
            used_environment = used.environment
            joins.append(ros1_join(used_environment))
            lines.append(used.line)
        if graph.ros2 is not None:
            from rostether.ros2.actions.board_graph import BoardJoin

            access = await stack.enter_async_context(
                ros2_access(graph.ros2, msg_paths, reach=graph.zenoh, params_files=graph.params_files)
            )
            boards = BoardJoin(access.join, access.types, partial(native_session, graph, msg_paths))
            stack.push_async_callback(boards.close)
            joins.append(boards)
            types = access.types
            # Other nodes may use any type; do not search folders for it in the event loop.
            await types.searched()
            lines.append(access.line)
        join = joins[0] if len(joins) == 1 else JointJoin(joins)
        yield ServedGraphs(join, used_environment, tuple(lines), types)


@asynccontextmanager
async def native_session(graph: GraphOptions, msg_paths: Sequence[Path]) -> AsyncIterator[NativeSession]:
    """Join the boards' ROS 2 graph again, with ROS 2's own types: the boards' session has ROS 1 types.

    Raises ConfigError, GraphError.
    """
    from rostether.ros2.actions.board_graph import NativeSession
    from rostether.ros2.types.native_registry import NativeRegistry
    from rostether.ros2.types.native_types import NativeTypes

    assert graph.ros2 is not None
    types = NativeTypes(NativeRegistry.from_environment(msg_paths))
    await types.searched()
    # The boards' session is the router if this process has one; this session must not be another.
    reach = ZenohReach(RouterChoice.NEVER, graph.zenoh.connect)
    async with ros2_access(graph.ros2, msg_paths, reach=reach, types=types) as access:
        yield NativeSession(access.join, types)


def check_master(graph: GraphOptions, port: int | None) -> None:
    """Raise ConfigError if both --master and --master-port were given."""
    if graph.master is not None and port is not None:
        raise ConfigError("--master joins a master, and --master-port starts one; give only one of them")


class UsedMaster(Struct, frozen=True):
    """The environment to join with, a line for users about its master, and whether it was started here."""

    environment: RosEnvironment
    line: str
    is_started_here: bool = False


@asynccontextmanager
async def used_master(
    environment: RosEnvironment, *, is_chosen: bool = False, port: int | None = None
) -> AsyncIterator[UsedMaster]:
    """Find the master to use; if there is none, run one until the end of the block.

    `is_chosen` is true if the user named it (`--master`); `port` is that of a new master (`--master-port`).
    Raises GraphError if another program uses the port.
    """
    if is_chosen or (environment.master_uri_is_set and not environment.master.is_loopback):
        line = f"Using the ROS master at {environment.master_uri}"
        if not await master_answers(environment):
            line += ", which does not answer yet; waiting for it"
        yield UsedMaster(environment, line)
        return
    if port is not None:
        environment = replace(environment, master_uri=format_uri("localhost", port))
    used = UsedMaster(environment, f"Joining the ROS master at {environment.master_uri}")
    async with AsyncExitStack() as stack:
        if not await master_answers(environment):
            try:
                used = await stack.enter_async_context(own_master(environment))
            except GraphError:
                # Another program took the port in the meantime; join it if it is a master.
                if not await master_answers(environment):
                    raise
        yield used


@asynccontextmanager
async def own_master(environment: RosEnvironment) -> AsyncIterator[UsedMaster]:
    """Run a master at the environment's URI until the end of the block. Raises GraphError."""
    from rostether.ros1.roscore import Roscore

    async with closed_at_end(await Roscore.start(environment, port=environment.master.port)) as core:
        line = f"Started a ROS master: ROS_MASTER_URI={core.uri.rstrip('/')}"
        yield UsedMaster(environment, line, is_started_here=True)


async def wait_for_answer(environment: RosEnvironment) -> None:
    """Wait until a ROS master answers at the environment's URI."""
    # No event announces a master, so it is asked repeatedly.
    while True:
        if await master_answers(environment):
            return
        await asyncio.sleep(_POLL_S)


async def master_answers(environment: RosEnvironment) -> bool:
    """Return whether a ROS master answers at the environment's URI."""
    async with closed_at_end(MasterClient(environment.master_uri, TOOL_NAME)) as client:
        try:
            async with asyncio.timeout(_ANSWER_LIMIT_S):
                await client.get_pid()
        except (MasterUnreachableError, TimeoutError):
            return False
    return True
