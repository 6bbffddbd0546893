"""Simulated boards as link addresses: builds and starts `sim:blink.ino`, and serves its serial port."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.bridge.identity import legal_base_name, numbered
from rostether.bridge.reporter import Notices, Reporter
from rostether.cli.access.ros1_access import type_store
from rostether.cli.board.opencr import OPENCR, start_opencr
from rostether.cli.board.qemu import find_program, measure_program, start_in_qemu
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.errors import GraphError
from rostether.graph.ports import Graph, JoinGraph, Level
from rostether.mechanisms.block_end import closed_at_end, task_beside
from rostether.simulation.qemu import MACHINES, QemuBoard
from rostether.simulation.simavr.board_events import BoardEvent, show_event
from rostether.simulation.simavr.kinds import kind_of
from rostether.transports.address import Address, ProgramSize, SerialAddress, SimAddress, SimulationPauses

if TYPE_CHECKING:
    from rostether.simulation.opencr.board import OpenCrBoard
    from rostether.simulation.simavr.simulated_board import SimulatedBoard
    from rostether.simulation.simavr.simulation_node import NodeBoard

# Events of every start; another line already reports the start.
_START_EVENTS = ("ready", "reset")
# Events that the board's node requests; they are not reported.
_REQUESTED_BY_NODE = frozenset(("pins", "servo"))
# Events that show a fault of the sketch, or a simulation that is too slow.
_WARNINGS = (
    "asleep",
    "bad_opcode",
    "bad_read",
    "bad_write",
    "behind",
    "lost_serial",
    "overrun",
    "restart",
    "stack_low",
    "stack_overflow",
)


@asynccontextmanager
async def simulated(
    links: Sequence[Address],
    reporter: Reporter,
    msg_paths: Sequence[Path] = (),
    join: JoinGraph | None = None,
) -> AsyncIterator[list[Address]]:
    """Start the simulated boards among the links, and yield the links with serial ports in their place.

    With `join`, each AVR board and OpenCR is also a node that shows its pins and accepts commands.

    Raises BoardError, ConfigError for unknown boards, FirmwareError for sketches that cannot be built.
    """
    from rostether.simulation.opencr.node_board import OpenCrNodeBoard

    async with AsyncExitStack() as stack:
        names: list[str] = []
        opened: list[Address] = []
        for link in links:
            if not isinstance(link, SimAddress):
                opened.append(link)
                continue
            name = link.name or _name(Path(link.program), names)
            names.append(name)
            size: ProgramSize | None = None
            pauses: SimulationPauses | None = None
            shown: NodeBoard | None = None
            if link.board in MACHINES:
                qemu = await _start_qemu(link, reporter, stack)
                address, report = qemu.address, _report_end(qemu, link, reporter)
            elif link.board == OPENCR:
                opencr = await _start_opencr(link, reporter, stack, msg_paths)
                address, report = opencr.address, _report_end(opencr, link, reporter)
                shown = OpenCrNodeBoard(opencr)
            else:
                board, size = await _start_avr(link, reporter, stack, msg_paths)
                address, report = board.address, _report_events(board, link, reporter)
                shown, pauses = board, board.pauses
            if join is not None and shown is not None:
                joining = partial(join, f"{name}_simulation", namespace=f"/{(link.ns or '').strip('/')}")
                await stack.enter_async_context(task_beside(_run_node(shown, link, joining, reporter)))
            # The report ends before its board: the end of a board that is stopped on purpose is not reported.
            await stack.enter_async_context(task_beside(report))
            opened.append(SerialAddress(address, name=name, ns=link.ns, program=size, pauses=pauses))
        yield opened


async def _start_avr(
    link: SimAddress, reporter: Reporter, stack: AsyncExitStack, msg_paths: Sequence[Path]
) -> tuple[SimulatedBoard, ProgramSize | None]:
    """Start a board that ends with the exit stack; return it, and the memory use of its program."""
    from rostether.simulation.simavr.simulated_board import SimulatedBoard

    kind_of(link.board)
    preparing = f"preparing a simulated {link.board} for {link.program}; this takes longer the first time"
    with reported_when_long(partial(reporter.report, Level.INFO), preparing):
        program = await find_program(Path(link.program), link.board, msg_paths)
        size = await asyncio.to_thread(measure_program, program, link.board)
        board = await stack.enter_async_context(
            await SimulatedBoard.start(
                program, board=link.board, commands=link.commands, uart=link.uart, seed=link.seed
            )
        )
    note = f" ({board.note})" if board.note else ""
    reporter.report(Level.INFO, f"simulated {board.kind} runs {link.program} at {board.address}{note}")
    return board, size


async def _run_node(
    board: NodeBoard, link: SimAddress, join: Callable[[], Awaitable[Graph]], reporter: Reporter
) -> None:
    from rostether.graph.typed_graph import TypedGraph
    from rostether.simulation.opencr.board import PIN_FULL_SCALE_V
    from rostether.simulation.simavr.simulation_node import SimulationNode

    try:
        async with closed_at_end(await join()) as graph:
            typed = TypedGraph(graph, type_store())
            if link.board == OPENCR:
                # The robot of an OpenCR always has wheels.
                commands = ("wheels", *link.commands)
                node = SimulationNode(
                    board, typed, commands, max_volts=PIN_FULL_SCALE_V, has_servo_pins=False
                )
            else:
                node = SimulationNode(board, typed, link.commands)
            await node.run()
    except GraphError as error:
        reporter.report(Level.WARN, f"{link}: the dashboard cannot show its pins: {error}")


async def _start_qemu(link: SimAddress, reporter: Reporter, stack: AsyncExitStack) -> QemuBoard:
    """Start a Cortex-M that ends with the exit stack."""
    has_other_options = bool(link.commands or link.uart is not None or link.seed)
    board = await stack.enter_async_context(
        await start_in_qemu(Path(link.program), link.board, has_other_options=has_other_options)
    )
    reporter.report(Level.INFO, f"simulated {link.board} runs {link.program} at {board.address}")
    return board


async def _start_opencr(
    link: SimAddress, reporter: Reporter, stack: AsyncExitStack, msg_paths: Sequence[Path]
) -> OpenCrBoard:
    """Start an OpenCR that ends with the exit stack."""
    has_other_options = bool(link.uart is not None or link.seed)
    board = await stack.enter_async_context(
        await start_opencr(
            Path(link.program), link.commands, msg_paths=msg_paths, has_other_options=has_other_options
        )
    )
    board.on_event = lambda event: reporter.report(Level.INFO, f"{link}: {show_event(event).strip()}")
    reporter.report(Level.INFO, f"simulated {OPENCR} runs {link.program} at {board.address}")
    return board


def _name(program: Path, used: Sequence[str]) -> str:
    base_name = legal_base_name(program.resolve().stem)
    return next(name for number in count(1) if (name := numbered(base_name, number)) not in used)


async def _report_end(board: QemuBoard | OpenCrBoard, link: SimAddress, reporter: Reporter) -> None:
    await board.wait_end()
    reason = f": {board.exit_message}" if board.exit_message else ""
    reporter.report(Level.ERROR, f"{link}: the simulated board has ended{reason}")


async def _report_events(board: SimulatedBoard, link: SimAddress, reporter: Reporter) -> None:
    notices = Notices(reporter, "", asyncio.get_running_loop().time)
    hidden = _REQUESTED_BY_NODE - {word.partition(" ")[0] for word in link.commands}

    def report(event: BoardEvent) -> None:
        text = f"{link}: {show_event(event).strip()}"
        if event.name in _WARNINGS:
            # There is an event for each lost byte: thousands if a program does not read.
            notices.report_episode(event.name, Level.WARN, text)
        else:
            notices.show(Level.INFO, text)

    for event in [each for each in board.recent if each.name not in _START_EVENTS]:
        report(event)
    async for event in board.events():
        if event.name not in hidden:
            report(event)
    reporter.report(Level.ERROR, f"{link}: the simulated board has ended")
