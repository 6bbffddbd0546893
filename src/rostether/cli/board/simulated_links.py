"""Simulated boards as link addresses: `sim:blink.ino` is built, started, and served at its serial port."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator, Coroutine, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.board.qemu import MACHINES, start_in_qemu
from rostether.graph.ports import Level
from rostether.transports.address import Address, SerialAddress, SimAddress

if TYPE_CHECKING:
    from rostether.bridge.reporter import Reporter
    from rostether.simulation.simavr.board_events import BoardEvent
    from rostether.simulation.simavr.simulated_board import SimulatedBoard

_KNOWN_FROM_ITS_START = ("ready", "reset")
_WARNINGS = (
    "asleep",
    "bad_opcode",
    "bad_read",
    "bad_write",
    "behind",
    "lost_serial",
    "overrun",
    "restart",
    "stack",
    "stack_overflow",
)


@asynccontextmanager
async def simulated(
    links: Sequence[Address], reporter: Reporter, msg_paths: Sequence[Path] = ()
) -> AsyncIterator[list[Address]]:
    """Start the simulated boards among the links, and give the links with their serial ports instead.

    Raises BoardError, ConfigError for unknown boards, FirmwareError for sketches that cannot be built.
    """
    async with AsyncExitStack() as stack:
        names: list[str] = []
        opened: list[Address] = []
        reports: list[asyncio.Task[None]] = []
        for link in links:
            if not isinstance(link, SimAddress):
                opened.append(link)
                continue
            name = link.name or _name(Path(link.program), names)
            names.append(name)
            if link.board in MACHINES:
                place, report = await _start_qemu(link, reporter, stack)
            else:
                place, report = await _start_avr(link, reporter, stack, msg_paths)
            reports.append(asyncio.get_running_loop().create_task(report))
            opened.append(SerialAddress(place, name=name, ns=link.ns))
        # Ended first: a board that we end has nothing more to report.
        stack.push_async_callback(_end, reports)
        yield opened


async def _start_avr(
    link: SimAddress, reporter: Reporter, stack: AsyncExitStack, msg_paths: Sequence[Path]
) -> tuple[str, Coroutine[None, None, None]]:
    """Start a board that ends with the stack; return its serial port, and what reports of it."""
    from rostether.cli.board.program import find_program
    from rostether.cli.shell.slow_notice import reported_when_long
    from rostether.simulation.simavr.kinds import kind_of
    from rostether.simulation.simavr.simulated_board import SimulatedBoard

    kind_of(link.board)
    preparing = f"preparing a simulated {link.board} for {link.program}; this takes longer the first time"
    with reported_when_long(partial(reporter.line, Level.INFO), preparing):
        program = await find_program(Path(link.program), link.board, msg_paths)
        board = await stack.enter_async_context(
            await SimulatedBoard.start(
                program, board=link.board, words=link.words, uart=link.uart, seed=link.seed
            )
        )
    reporter.line(Level.INFO, f"simulated {board.kind} runs {link.program} at {board.address}{_note(board)}")
    return board.address, _report(board, str(link), reporter)


async def _start_qemu(
    link: SimAddress, reporter: Reporter, stack: AsyncExitStack
) -> tuple[str, Coroutine[None, None, None]]:
    """As `_start_avr`, for a program of a Cortex-M."""
    has_words = bool(link.words or link.uart is not None or link.seed)
    board = await stack.enter_async_context(
        await start_in_qemu(Path(link.program), link.board, has_words=has_words)
    )
    reporter.line(Level.INFO, f"simulated {link.board} runs {link.program} at {board.address}")

    async def report() -> None:
        await board.wait_end()
        said = f": {board.last_words}" if board.last_words else ""
        reporter.line(Level.ERROR, f"{link}: the simulated board has ended{said}")

    return board.address, report()


def _note(board: SimulatedBoard) -> str:
    return f" ({board.note})" if board.note else ""


def _name(program: Path, taken: Sequence[str]) -> str:
    stem = re.sub(r"\W", "_", program.resolve().stem, flags=re.ASCII)
    name = stem if stem[:1].isalpha() else f"board_{stem}"
    number = 2
    while (numbered := name if number == 2 and name not in taken else f"{name}_{number}") in taken:
        number += 1
    return numbered


async def _report(board: SimulatedBoard, title: str, reporter: Reporter) -> None:
    from rostether.bridge.reporter import Notices
    from rostether.simulation.simavr.board_events import show_event

    notices = Notices(reporter, "", asyncio.get_running_loop().time)

    def tell(event: BoardEvent) -> None:
        text = f"{title}: {show_event(event).strip()}"
        if event.name in _WARNINGS:
            # One event for each lost byte: thousands, when a program does not read.
            notices.episode(event.name, Level.WARN, text)
        else:
            notices.show(Level.INFO, text)

    for event in [each for each in board.recent if each.name not in _KNOWN_FROM_ITS_START]:
        tell(event)
    async for event in board.events():
        tell(event)
    reporter.line(Level.ERROR, f"{title}: the simulated board has ended")


async def _end(tasks: Sequence[asyncio.Task[None]]) -> None:
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
