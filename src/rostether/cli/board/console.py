"""A simulated board in the terminal: its commands on standard input, its events on standard output."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

from rostether.cli.shell.input import input_lines
from rostether.cli.shell.output import warn, write_json, write_line, write_result
from rostether.errors import BoardError, ConfigError
from rostether.mechanisms.block_end import task_beside
from rostether.simulation.simavr import board_events
from rostether.simulation.simavr.board_events import BoardEvent, is_text

# A sketch's line arrives in pieces. At 300 baud, the next character follows within this time.
LINE_GAP_S = 0.1
MAX_LINE_BYTES = 200


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
    write_result(
        {"event": event.name, "time_s": event.time_s, **event.values},
        board_events.show_event(event),
        as_json=as_json,
    )


class EventPrinter:
    """Prints the events of a board, and the text that its sketch prints by line."""

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._line = b""
        self._line_s = 0.0
        self._timer: asyncio.TimerHandle | None = None
        self._failure: Exception | None = None

    def show(self, event: BoardEvent) -> None:
        """Print an event; an incomplete line of text is printed when the sketch pauses."""
        if self._failure is not None:
            raise self._failure
        if event.name == "serial" and not self._as_json:
            data = bytes.fromhex(event["data"])
            if is_text(data):
                self._add(data, event.time_s)
                return
        self.flush()
        show_event(event, as_json=self._as_json)

    def flush(self) -> None:
        """Print an incomplete line of text."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._print(len(self._line))

    def _add(self, text: bytes, time_s: float) -> None:
        if not self._line:
            self._line_s = time_s
        self._line += text
        self._print(self._line.rfind(b"\n") + 1)
        if len(self._line) >= MAX_LINE_BYTES:
            self._print(len(self._line))
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(LINE_GAP_S, self._flush_after_gap)

    def _flush_after_gap(self) -> None:
        try:
            self.flush()
        except Exception as error:  # noqa: BLE001 - a closed pipe or a full disk; `show` raises it
            self._failure = error

    def _print(self, count: int) -> None:
        if count:
            data, self._line = self._line[:count], self._line[count:]
            show_event(BoardEvent("serial", self._line_s, {"data": data.hex()}), as_json=False)
