"""`rostether demo`: a master, the bridge and a simulated board, shown live."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import click

from rostether.bridge.reporter import Reporter
from rostether.bridge.supervisor import Supervisor
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.master_choice import master_answers, used_master
from rostether.cli.access.ros1_access import joining_ros1, read_environment
from rostether.cli.access.ros_choice import Middleware
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.bridge.demo_view import DemoView, RecentLines, our_command
from rostether.cli.bridge.device_options import config_option, read_devices
from rostether.cli.bridge.serving import bridge
from rostether.cli.dashboard.served import DashboardSettings, dashboard_beside
from rostether.cli.shell.output import write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import GraphError, RostetherError, UnknownNameError
from rostether.extras import install_command
from rostether.graph.joint_join import JointJoin
from rostether.graph.ports import JoinGraph, Level, ParamValue
from rostether.msgdef.registry import Registry
from rostether.ports.device_book import DeviceBook
from rostether.ros1.environment import RosEnvironment, format_uri, is_loopback
from rostether.ros1.node.master_client import MasterClient
from rostether.serde.store import TypeStore
from rostether.transports.address import parse_address

BOARD_NAME = "virtual_board"
# More demos than this on one master are a mistake.
MAX_DEMOS = 100
WATCHED_TOPICS = {
    "/ultrasound": "sensor_msgs/Range",
    "/led": "std_msgs/Bool",
    "/count": "std_msgs/UInt32",
    "/imu_data": "sensor_msgs/Imu",
    "/tf": "tf/tfMessage",
}
BOARD_PARAMETERS: dict[str, ParamValue] = {"blink_hz": 0, "frame_id": "base_link"}
REFRESH_S = 0.25
PLAIN_LINE_S = 1.0


@click.command(
    cls=Verb,
    examples="""
    rostether demo                 run until Ctrl-C
    rostether demo --seconds 5     stop after 5 s; fails if no message arrived
    rostether demo --join          show the board to the robot that runs here
    """,
)
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.1),
    help="Stop after this many seconds (default: run until Ctrl-C).",
)
@config_option
@click.option("--ros1", is_flag=True, help="Use only the ROS 1 graph.")
@click.option("--join", is_flag=True, help="Join the ROS graph that runs here, instead of one of its own.")
@click.option("--no-page", is_flag=True, help="Do not serve the dashboard.")
@graph_options(master="", ros=False)
def demo(
    seconds: float | None, config: Path | None, ros1: bool, join: bool, no_page: bool, graph: GraphOptions
) -> None:
    """Run a simulated board and show its topics. Needs no hardware, no ROS and no setup.

    The board is a node on a ROS 1 graph, and also on a ROS 2 graph if zenoh is installed (unless --ros1).
    Robots that run on this machine do not see it, unless you add --join.

    A browser shows it at the address of the dashboard. Settings are read only from a file given with
    --config; the board's name is virtual_board.
    """
    # The user's settings for real boards must not make the demo fail.
    devices = read_devices(config, ()) if config is not None else None
    run(
        _demo(read_environment(graph), seconds, devices, only_ros1=ros1, joins=join, has_page=not no_page),
        is_service=True,
    )


async def _demo(
    environment: RosEnvironment,
    seconds: float | None,
    devices: DeviceBook | None,
    *,
    only_ros1: bool,
    joins: bool,
    has_page: bool,
) -> None:
    is_live = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    recent = RecentLines()
    reporter = recent if is_live else ConsoleReporter()
    store = TypeStore(Registry())
    async with AsyncExitStack() as stack:
        if not joins:
            environment = await _with_own_master(environment)
        used = await stack.enter_async_context(used_master(environment))
        reporter.line(Level.INFO, used.line)
        board_name = await _free_name(used.environment)
        address = parse_address(f"tcp://127.0.0.1:0?name={board_name}")
        join: JoinGraph = joining_ros1(used.environment)
        ros2 = None if only_ros1 else await _joining_ros2(stack, reporter, joins=joins)
        if ros2 is not None:
            join = JointJoin([join, ros2])
        supervisor = await stack.enter_async_context(
            bridge(join, [address], reporter, devices=devices, diagnostics=has_page)
        )
        dashboard = await stack.enter_async_context(
            dashboard_beside(
                DashboardSettings(wider="`rostether dashboard --listen 0.0.0.0`") if has_page else None,
                ServedGraphs(join, used.environment, ()),
                (),
                reporter.line,
            )
        )
        view = DemoView(
            supervisor.boards,
            asyncio.get_running_loop().time,
            recent,
            used.environment.master_uri,
            is_in_ros2=ros2 is not None,
            dashboard_url=dashboard.url if dashboard is not None else "",
        )
        await stack.enter_async_context(_watch(used.environment, store, view, board_name))
        await stack.enter_async_context(_virtual_board(supervisor))
        # The board outlives the bridge: otherwise it would be reported as lost.
        stack.push_async_callback(supervisor.close)
        show = _show_live(view) if is_live else _show_lines(view)
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(show, seconds)
    if not view.has_flowed:
        raise GraphError("no message of the simulated board arrived through the ROS graph; please report it")


async def _with_own_master(environment: RosEnvironment) -> RosEnvironment:
    """Return the environment with a master of our own: at the usual port, or at the next that has none."""
    usual = environment.master if is_loopback(environment.master.host) else RosEnvironment().master
    for port in range(usual.port, usual.port + MAX_DEMOS):
        own = replace(environment, master_uri=format_uri(usual.host, port), master_uri_is_set=True)
        if not await master_answers(own):
            return own
    raise GraphError(f"{MAX_DEMOS} ROS masters already run here; stop one first")


async def _joining_ros2(stack: AsyncExitStack, reporter: Reporter, *, joins: bool) -> JoinGraph | None:
    """Return the factory of ROS 2 nodes over zenoh; None, with a line about the reason, if not possible."""
    if find_spec("zenoh") is None:
        reporter.line(Level.INFO, f"Not on ROS 2; to add it, run: {install_command('zenoh')}")
        return None
    from rostether.cli.access.ros2_access import ros2_access

    async with AsyncExitStack() as joined:
        try:
            access = await joined.enter_async_context(ros2_access(Middleware.ZENOH))
        except RostetherError as error:
            reporter.line(Level.WARN, f"Not on ROS 2: {error}")
            return None
        # Without a router of its own it would be in a graph that runs already.
        if not joins and not access.is_router:
            reporter.line(Level.INFO, "Not on ROS 2: another graph runs here; --join joins it")
            return None
        stack.push_async_callback(joined.pop_all().aclose)
    reporter.line(
        Level.INFO, f"{access.line}; to watch it, run: {our_command()} topic echo --ros2 zenoh /ultrasound"
    )
    return access.join


async def _free_name(environment: RosEnvironment) -> str:
    """Return a name that no other demo uses: a second node with that name would replace the first."""
    client = MasterClient(environment.master_uri, "/rostether")
    try:
        for number in range(1, MAX_DEMOS):
            name = BOARD_NAME if number == 1 else f"{BOARD_NAME}_{number}"
            await client.lookup_node(f"/{name}")
    except UnknownNameError:
        return name
    finally:
        await client.close()
    raise GraphError(f"{MAX_DEMOS - 1} demos already run; stop one first")


async def _show_live(view: DemoView) -> None:
    from rich.live import Live

    with Live(view.render(), auto_refresh=False) as live:
        while True:
            await asyncio.sleep(REFRESH_S)
            view.update()
            live.update(view.render(), refresh=True)


async def _show_lines(view: DemoView) -> None:
    while True:
        for _ in range(round(PLAIN_LINE_S / REFRESH_S)):
            await asyncio.sleep(REFRESH_S)
            view.update()
        write_line(view.line())


@asynccontextmanager
async def _virtual_board(supervisor: Supervisor) -> AsyncIterator[None]:
    """Plug the simulated board in."""
    from rostether.device import Device
    from rostether.simulation.virtual_board import VirtualBoard

    async with Device(supervisor.listening_on[0]) as device:
        playing = asyncio.get_running_loop().create_task(VirtualBoard(device).run())
        try:
            yield
        finally:
            playing.cancel()
            await asyncio.gather(playing, return_exceptions=True)


@asynccontextmanager
async def _watch(
    environment: RosEnvironment, store: TypeStore, view: DemoView, board_name: str
) -> AsyncIterator[None]:
    """Subscribe like any other node, so that the table shows data from the graph."""
    from rostether.mechanisms.anonymous import anonymous_name
    from rostether.ros1.node.node import join_ros1

    graph = await join_ros1(anonymous_name("demo_view"), environment=environment)
    try:
        for name, value in BOARD_PARAMETERS.items():
            await graph.set_param(f"/{board_name}/{name}", value)
        for topic, type_name in WATCHED_TOPICS.items():
            message_type = store.registry.message_type(type_name)
            await graph.subscribe(topic, message_type, partial(view.saw, topic, store.codec(type_name)))
        yield
    finally:
        await graph.close()
