"""A simulated board in the terminal: its commands on standard input, its events on standard output."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.shell.input import input_lines
from rostether.cli.shell.output import warn, write_json, write_line, write_result
from rostether.errors import BoardError, ConfigError
from rostether.mechanisms.block_end import task_beside

if TYPE_CHECKING:
    from rostether.simulation.simavr.board_events import BoardEvent


@asynccontextmanager
async def handling_commands(execute: Callable[[str], Awaitable[None]]) -> AsyncIterator[None]:
    """Handle the lines of standard input during the block; a line that `execute` refuses is reported."""

    async def listen() -> None:
        async for line in input_lines():
            if line.strip():
                try:
                    await execute(line)
                except (BoardError, ConfigError) as error:
                    warn(f"rostether: error: {error}")

    async with task_beside(listen()):
        yield


def show_start(
    title: str, kind: str, program: Path, address: str, link_path: Path | None, note: str = ""
) -> None:
    """Print which program a board runs, and its serial port; as a JSON event if `title` is empty."""
    if not title:
        write_json({"event": "ready", "board": kind, "link": address})
        return
    linked = f", linked at {link_path}" if link_path else ""
    write_line(f"{title} runs {program}; serial port {address}{linked}{note}")


def show_event(event: BoardEvent, *, as_json: bool) -> None:
    """Print an event of a board."""
    from rostether.simulation.simavr import board_events

    write_result(
        {"event": event.name, "time_s": event.time_s, **event.values},
        board_events.show_event(event),
        as_json=as_json,
    )
