"""`rostether demo`: a master, the bridge and a simulated board, shown live."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click

from rostether.bridge.settings import BoardNodes
from rostether.bridge.supervisor import Links, Supervisor
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.ros1_access import read_environment, ros1_join, type_store
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.bridge.options import read_devices
from rostether.cli.bridge.serving import serving
from rostether.cli.dashboard.optional import optional_dashboard
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.cli.demo.setup import PYTHON, UNO, demo_board, demo_master, demo_ros2, prepare_board
from rostether.cli.demo.view import DemoFacts, DemoScreen, DemoView, RecentLines
from rostether.cli.shell.keys import split_keys, typed_keys
from rostether.cli.shell.option_group import PATH, PORT, NumberRange, flag, option, option_group
from rostether.cli.shell.output import shows_live, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import GraphError
from rostether.graph.joint_join import JointJoin
from rostether.graph.ports import JoinGraph, Level, Publisher
from rostether.mechanisms.anonymous import anonymous_name
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.tasks import occurs_within
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from rostether.simulation.ultrasound import Obstacle
from rostether.transports.address import WebAddress
from rostether.transports.opening import listen
from rostether.transports.web_boards import WebBoards

# Often enough to follow the obstacle, and slow enough to read the values.
REFRESH_S = 0.25
# A log needs fewer lines than a screen.
PLAIN_LINE_S = 1.0
# How far a key moves the obstacle.
STEP_M = 0.1
# The arrow keys, as terminals send them in their two modes.
FARTHER = (b"\033[A", b"\033OA", b"\033[C", b"\033OC")
NEARER = (b"\033[B", b"\033OB", b"\033[D", b"\033OD")


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """The options of `demo`."""

    duration_s: float | None = option(
        "--duration SECONDS",
        "Stop after this many seconds (default: run until Ctrl-C).",
        type=NumberRange(min=0.1),
    )
    board: str | None = option(
        "--board",
        "A simulated Arduino Uno with compiled firmware, or a board in Python "
        "(default: uno where avr-gcc and libsimavr are installed).",
        type=click.Choice((UNO, PYTHON)),
    )
    config: Path | None = option(
        "--config FILE", "File of board names and settings (default: none).", type=PATH
    )
    ros1: bool = flag("--ros1", "Use only the ROS 1 graph.")
    join: bool = flag("--join", "Join the ROS graph that runs here, instead of starting a separate one.")
    port: int | None = option(
        "--port", "Start the ROS master on this port (default: 11311, or the next free port).", type=PORT
    )
    no_page: bool = flag("--no-page", "Do not serve the dashboard.")


@verb(
    "demo",
    """
    rostether demo                 run until Ctrl-C
    rostether demo --duration 5    stop after 5 s; fails if no message arrived
    rostether demo --board python  no compiler, a board in Python
    rostether demo --join          show the board to the robot that runs here
    """,
    is_service=True,
    old_options={"--seconds": "--duration"},
)
@option_group("options", DemoOptions)
@graph_options(master=False, ros=False)
async def demo(options: DemoOptions, graph: GraphOptions) -> None:
    """Run a simulated board and show its topics. Needs no hardware, no ROS and no setup.

    The board is an Arduino Uno that runs a compiled sketch, where avr-gcc and libsimavr are installed, else a
    Python program. It is a node on a ROS 1 graph, and also on a ROS 2 graph if zenoh is installed (unless
    --ros1). Robots that run on this machine do not see it, unless you add --join.

    Press l to switch the LED, and the arrow keys to move the obstacle. A browser shows the board at the
    address of the dashboard. Settings are read only from a file given with --config; the board's name is
    virtual_board.
    """
    if options.join and options.port is not None:
        raise click.UsageError("--join uses the master that runs; omit --port")
    # The user's settings for real boards must not make the demo fail.
    devices = read_devices(options.config, ()) if options.config is not None else None
    is_live = shows_live()
    recent = RecentLines()
    reporter = recent if is_live else ConsoleReporter()
    clock = asyncio.get_running_loop().time
    obstacle = Obstacle()
    controls = Controls(obstacle, clock)
    async with AsyncExitStack() as stack:
        # Keys are read from the start, so that the terminal does not show those that are pressed early.
        has_keys = is_live and stack.enter_context(typed_keys(controls.press))
        used = await stack.enter_async_context(
            demo_master(read_environment(graph), joins=options.join, port=options.port)
        )
        reporter.report(Level.INFO, used.line)
        name = await prepare_board(used.environment)
        board = await stack.enter_async_context(demo_board(options.board, name, obstacle, reporter))
        reporter.report(Level.INFO, f"Board: {board.title}")
        join: JoinGraph = ros1_join(used.environment)
        ros2 = None if options.ros1 else await demo_ros2(stack, reporter, joins=options.join)
        if ros2 is not None:
            join = JointJoin([join, ros2])
        boards = WebBoards()
        supervisor = Supervisor(
            join,
            type_store(),
            reporter=reporter,
            devices=devices,
            nodes=BoardNodes(diagnostics=True),
            links=Links(listen=partial(listen, web_boards=boards)),
        )
        await stack.enter_async_context(serving(supervisor, [board.link, WebAddress()], reporter))
        dashboard = await stack.enter_async_context(
            optional_dashboard(
                DashboardSettings(remote_option="`rostether dashboard --listen 0.0.0.0`", boards=boards)
                if not options.no_page
                else None,
                ServedGraphs(join, used.environment, ()),
                (),
                recent.report_warning if is_live else reporter.report,
            )
        )
        view = DemoView(supervisor.boards, clock)
        controls.advertise = await stack.enter_async_context(_watched(used.environment, board.topics, view))
        await stack.enter_async_context(board.plug_in(supervisor, join))
        # The bridge closes before the board: otherwise it would report a lost board.
        stack.push_async_callback(supervisor.close)
        facts = DemoFacts(
            board.title,
            used.environment.master_uri,
            is_in_ros2=ros2 is not None,
            dashboard_url=dashboard.url if dashboard is not None else "",
            has_keys=has_keys,
        )
        show = _show_live(facts, view, recent, controls) if is_live else _show_lines(view)
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(show, options.duration_s)
    if not view.has_messages and not controls.quit.is_set():
        raise GraphError("no message of the simulated board arrived through the ROS graph; please report it")


class Controls:
    """The state that the keys change; q sets `quit`."""

    def __init__(self, obstacle: Obstacle, clock: Callable[[], float]) -> None:
        self.quit = asyncio.Event()
        # Advertises the LED's switch, at the first press: the dashboard has a button only for a topic that no
        # node publishes. None until the graph is joined.
        self.advertise: Callable[[], Coroutine[Any, Any, Publisher]] | None = None
        self._advertising: asyncio.Task[Publisher] | None = None
        self._obstacle = obstacle
        self._clock = clock
        self._waiting_toggles = 0

    def press(self, typed: bytes) -> None:
        """Handle the keys."""
        for key in split_keys(typed, FARTHER + NEARER):
            if key in FARTHER + NEARER:
                self._obstacle.move(STEP_M if key in FARTHER else -STEP_M, self._clock())
            elif key == b"l":
                self._waiting_toggles += 1
            elif key == b"q":
                self.quit.set()
        self.send_toggles()

    def send_toggles(self) -> None:
        """Publish the presses of the LED's key, once the board has subscribed."""
        if not self._waiting_toggles or self.advertise is None:
            return
        if self._advertising is None:
            self._advertising = asyncio.get_running_loop().create_task(self.advertise())
        if self._advertising.done() and (toggle := self._advertising.result()).subscriber_count:
            toggle.publish_raw([b""] * self._waiting_toggles)
            self._waiting_toggles = 0


async def _show_live(facts: DemoFacts, view: DemoView, recent: RecentLines, controls: Controls) -> None:
    from rich.live import Live

    screen = DemoScreen(facts, view, recent.lines)
    with Live(screen, auto_refresh=False) as live:
        while not controls.quit.is_set():
            controls.send_toggles()
            view.update()
            live.refresh()
            await occurs_within(controls.quit, REFRESH_S)


async def _show_lines(view: DemoView) -> None:
    while True:
        for _ in range(round(PLAIN_LINE_S / REFRESH_S)):
            await asyncio.sleep(REFRESH_S)
            view.update()
        write_line(view.line())


@asynccontextmanager
async def _watched(
    environment: RosEnvironment, topics: Mapping[str, str], view: DemoView
) -> AsyncIterator[Callable[[], Coroutine[Any, Any, Publisher]]]:
    """Subscribe like any other node, so that the view has data from the graph.

    Yields a function that advertises the LED's switch.
    """
    store = TypeStore(Registry())
    async with closed_at_end(await join_ros1(anonymous_name("demo_view"), environment=environment)) as graph:
        for topic, type_name in topics.items():
            message_type = store.registry.message_type(type_name)
            await graph.subscribe(
                topic, message_type, partial(view.add_messages, topic, store.codec(type_name))
            )
        yield partial(graph.advertise, "/toggle_led", store.registry.message_type("std_msgs/Empty"))
