"""The graphs and the board of the demo.

By default the graphs are its own, so that its board stays out of a running robot's graph. The board is AVR
firmware on a simulated Arduino Uno, or a Python program.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from functools import partial
from importlib.util import find_spec
from math import inf, isinf
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from rostether.bridge.reporter import Reporter
from rostether.bridge.supervisor import Supervisor
from rostether.cli.access.graph_options import Middleware
from rostether.cli.access.ros1_access import type_store
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.access.served_graphs import UsedMaster, master_answers, own_master, used_master
from rostether.cli.board.qemu import find_program, measure_program
from rostether.cli.demo.view import command_to_type
from rostether.cli.shell.output import warn
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.errors import BoardError, GraphError, RostetherError, UnknownNameError
from rostether.extras import install_command
from rostether.graph.ports import JoinGraph, Level, ParamValue
from rostether.mechanisms.block_end import closed_at_end, task_beside
from rostether.mechanisms.loopback import is_loopback
from rostether.ros1.environment import RosEnvironment, format_uri
from rostether.ros1.node.master_client import MasterClient
from rostether.simulation.ultrasound import Obstacle
from rostether.transports.address import Address, SerialAddress
from rostether.transports.address_parser import parse_address

if TYPE_CHECKING:
    from rostether.simulation.simavr.simulation_node import SimulationNode

UNO = "uno"
PYTHON = "python"
SKETCH = Path(__file__).parents[2] / "simulation" / "sketches" / "virtual_board"
TOPICS = {
    "/ultrasound": "sensor_msgs/Range",
    "/led": "std_msgs/Bool",
    "/count": "std_msgs/UInt32",
    "/tf": "tf/tfMessage",
}
# The baud rate of the sketch.
_BAUD = 115200
# In this time, a walking obstacle moves at most 10 cm.
_OBSTACLE_PERIOD_S = 0.1
# The first build takes seconds; later ones come from the cache.
_LONG_BUILD_S = 0.5
BOARD_NAME = "virtual_board"
# More demos than this on one machine are a mistake.
MAX_DEMOS = 100
BOARD_PARAMETERS: dict[str, ParamValue] = {"blink_hz": 0, "frame_id": "base_link"}

PlugIn = Callable[[Supervisor, JoinGraph], AbstractAsyncContextManager[None]]


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


class DemoBoard(Struct, frozen=True):
    """A running board: its description, link and topics (name: type), and what runs beside the bridge."""

    title: str
    link: Address
    topics: Mapping[str, str]
    plug_in: PlugIn


@asynccontextmanager
async def demo_board(
    kind: str | None, name: str, obstacle: Obstacle, reporter: Reporter
) -> AsyncIterator[DemoBoard]:
    """Run the board of this kind until the end of the block.

    None is a simulated Uno if one can run here, otherwise a Python program.

    Raises BoardError and FirmwareError if an Uno is requested and cannot run.
    """
    if kind == PYTHON:
        yield _python_board(name, obstacle)
        return
    async with AsyncExitStack() as stack:
        try:
            board = await stack.enter_async_context(_simulated_uno(name, obstacle, reporter))
        except RostetherError as error:
            if kind == UNO:
                raise
            reporter.report(Level.INFO, f"The board is a Python program: {error}")
            board = _python_board(name, obstacle)
        yield board


@asynccontextmanager
async def _simulated_uno(name: str, obstacle: Obstacle, reporter: Reporter) -> AsyncIterator[DemoBoard]:
    from rostether.firmware.toolchain import find_avr_toolchain
    from rostether.graph.typed_graph import TypedGraph
    from rostether.simulation.simavr.compile import missing_parts
    from rostether.simulation.simavr.simulated_board import SimulatedBoard
    from rostether.simulation.simavr.simulation_node import SimulationNode

    if missing := missing_parts():
        raise BoardError(missing)
    find_avr_toolchain()
    loop = asyncio.get_running_loop()
    building = "Building the sketch for a simulated Arduino Uno; the next start is faster."
    with reported_when_long(warn, building, after_s=_LONG_BUILD_S):
        program = await find_program(SKETCH, UNO)
        size = await asyncio.to_thread(measure_program, program, UNO)
        started = await SimulatedBoard.start(
            program, board=UNO, commands=[_range_command(obstacle, loop.time())]
        )
    async with started as board:

        @asynccontextmanager
        async def plug_in(_supervisor: Supervisor, join: JoinGraph) -> AsyncIterator[None]:
            async with closed_at_end(await join(f"{name}_simulation")) as graph:
                node = SimulationNode(
                    board, TypedGraph(graph, type_store()), on_command=partial(_place_obstacle, obstacle)
                )
                async with task_beside(node.run()), task_beside(_move_obstacle(node, obstacle, reporter)):
                    yield

        link = SerialAddress(board.address, baud=_BAUD, name=name, program=size, pauses=board.pauses)
        yield DemoBoard("Arduino Uno, simulated: a compiled AVR sketch", link, TOPICS, plug_in)


async def _move_obstacle(node: SimulationNode, obstacle: Obstacle, reporter: Reporter) -> None:
    """Set the simulated sensor to the obstacle's distance."""
    clock = asyncio.get_running_loop().time
    sent = ""
    try:
        while True:
            command = _range_command(obstacle, clock())
            if command != sent:
                await node.execute(command)
                sent = command
            await asyncio.sleep(_OBSTACLE_PERIOD_S)
    except BoardError as error:
        reporter.report(Level.ERROR, str(error))


def _range_command(obstacle: Obstacle, time_s: float) -> str:
    distance_m = obstacle.distance(time_s)
    return "range none" if isinf(distance_m) else f"range {distance_m:.4f}"


def _place_obstacle(obstacle: Obstacle, command: str) -> None:
    """Move the obstacle to the distance that a command from the graph has set on the board."""
    word, _, distance = command.strip().partition(" ")
    if word == "range":
        # The simulation also reads numbers that Python does not, such as 0x1p-1.
        with contextlib.suppress(ValueError):
            obstacle.place(inf if distance.strip() == "none" else float(distance))


def _python_board(name: str, obstacle: Obstacle) -> DemoBoard:
    @asynccontextmanager
    async def plug_in(supervisor: Supervisor, _join: JoinGraph) -> AsyncIterator[None]:
        from rostether.device import Device
        from rostether.simulation.virtual_board import VirtualBoard

        async with (
            Device(supervisor.listening_on[0]) as device,
            task_beside(VirtualBoard(device, obstacle=obstacle).run()),
        ):
            yield

    link = parse_address(f"tcp://127.0.0.1:0?name={name}")
    return DemoBoard("board in Python, over TCP", link, TOPICS | {"/imu_data": "sensor_msgs/Imu"}, plug_in)
