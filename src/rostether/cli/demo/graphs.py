"""The graphs of the demo: by default its own, so that its board stays out of a running robot's graph."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from importlib.util import find_spec

from msgspec.structs import replace

from rostether.bridge.reporter import Reporter
from rostether.cli.access.graph_options import Middleware
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.access.served_graphs import UsedMaster, master_answers, own_master, used_master
from rostether.cli.demo.view import command_to_type
from rostether.errors import GraphError, RostetherError, UnknownNameError
from rostether.extras import install_command
from rostether.graph.ports import JoinGraph, Level, ParamValue
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.loopback import is_loopback
from rostether.ros1.environment import RosEnvironment, format_uri
from rostether.ros1.node.master_client import MasterClient

BOARD_NAME = "virtual_board"
# More demos than this on one machine are a mistake.
MAX_DEMOS = 100
BOARD_PARAMETERS: dict[str, ParamValue] = {"blink_hz": 0, "frame_id": "base_link"}


@asynccontextmanager
async def demo_master(
    environment: RosEnvironment, *, joins: bool, port: int | None
) -> AsyncIterator[UsedMaster]:
    """Find the master to join, or run one until the end of the block.

    `port` is the port of a new master; None is the usual port, or the next free one. Raises GraphError if the
    port is in use.
    """
    if joins:
        async with used_master(environment) as used:
            yield used
        return
    usual = environment.master if is_loopback(environment.master.host) else RosEnvironment().master
    first = usual.port if port is None else port
    failure = GraphError(f"a ROS master uses port {first} already; choose another --port")
    async with AsyncExitStack() as stack:
        for tried in range(first, first + (MAX_DEMOS if port is None else 1)):
            own = replace(environment, master_uri=format_uri(usual.host, tried), master_uri_is_set=True)
            if await master_answers(own):
                continue
            try:
                used = await stack.enter_async_context(own_master(own))
            except GraphError as error:
                failure = error
                continue
            yield used
            return
    raise failure


async def demo_ros2(stack: AsyncExitStack, reporter: Reporter, *, joins: bool) -> JoinGraph | None:
    """Return the factory of ROS 2 nodes over zenoh, or report why there is none and return None."""
    if find_spec("zenoh") is None:
        reporter.report(Level.INFO, f"Not on ROS 2; to add it, run: {install_command('zenoh')}")
        return None
    async with AsyncExitStack() as joined:
        try:
            access = await joined.enter_async_context(ros2_access(Middleware.ZENOH))
        except RostetherError as error:
            reporter.report(Level.WARN, f"Not on ROS 2: {error}")
            return None
        # Without its own router, the demo would be in a graph that already runs.
        if not joins and not access.is_router:
            reporter.report(Level.INFO, "Not on ROS 2: another graph runs here; --join joins it")
            return None
        stack.push_async_callback(joined.pop_all().aclose)
    reporter.report(
        Level.INFO,
        f"{access.line}; to watch it, run: {command_to_type()} topic echo --ros2 zenoh /ultrasound",
    )
    return access.join


async def prepare_board(environment: RosEnvironment) -> str:
    """Return a name that no other demo uses, with the board's parameters set.

    A second node with the same name would replace the first. Raises GraphError if there are too many.
    """
    async with closed_at_end(MasterClient(environment.master_uri, "/rostether")) as client:
        for number in range(1, MAX_DEMOS):
            name = BOARD_NAME if number == 1 else f"{BOARD_NAME}_{number}"
            try:
                await client.lookup_node(f"/{name}")
            except UnknownNameError:
                for parameter, value in BOARD_PARAMETERS.items():
                    await client.set_param(f"/{name}/{parameter}", value)
                return name
    raise GraphError(f"{MAX_DEMOS - 1} demos already run; stop one first")
