"""`rostether monitor`: all boards and their topics at a glance, from /diagnostics."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sys
from collections.abc import Sequence
from contextlib import aclosing
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import TOOL_ALLOW, GraphOptions, graph_options
from rostether.cli.access.ros1_access import joined, read_environment
from rostether.cli.board.status import BoardStatus, read_statuses
from rostether.cli.bridge.monitor_table import table
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb

if TYPE_CHECKING:
    from rich.text import Text

    from rostether.graph.typed_graph import TypedGraph

TOPIC = "/diagnostics"
TYPE = "diagnostic_msgs/DiagnosticArray"

# Boards report once a second; half of that shows new values early enough.
REFRESH_S = 0.5

# After two missing reports the board or its bridge counts as gone.
STALE_S = 3.0

# How long a board that is gone stays in the table.
FORGET_S = 15.0

# The longest time that --once listens: rates are known after a board's second report.
ONCE_S = 6.0

# How long --once waits for a publisher: a newly connected board advertises within a second.
NOBODY_S = 2.5

# Any node may publish on /diagnostics; no user needs more boards than this.
MAX_BOARDS = 512

NOTHING = (
    "no board publishes on /diagnostics; start `rostether serve` (without --no-diagnostics) and connect a "
    "board"
)


class BoardsSeen:
    """The last status of each board, with its time of arrival."""

    def __init__(self) -> None:
        self._seen: dict[str, tuple[float, BoardStatus, int]] = {}

    def add_status(self, status: BoardStatus, now_s: float) -> None:
        """Handle a status."""
        if status.name in self._seen or len(self._seen) < MAX_BOARDS:
            count = self._seen[status.name][2] if status.name in self._seen else 0
            self._seen[status.name] = now_s, status, count + 1

    def boards(self, now_s: float) -> list[BoardStatus]:
        """Return the boards with their current state; a silent one is gone, and is removed later."""
        for name in [name for name, (at_s, _, _) in self._seen.items() if now_s - at_s > FORGET_S]:
            del self._seen[name]
        return [
            status if now_s - at_s <= STALE_S else _gone(status, now_s - at_s)
            for at_s, status, _ in self._seen.values()
        ]

    def known_count(self) -> int:
        """Return how many boards have reported often enough to know their rates."""
        return sum(count > 1 for _, _, count in self._seen.values())


@click.command(
    "monitor",
    cls=Verb,
    examples="""
    rostether monitor                     live, until Ctrl-C
    rostether monitor --once              one table
    rostether monitor --once --json       one object a board
    rostether monitor --json              one object a board and second
    """,
)
@click.option("--once", is_flag=True, help="Print one table and exit (the default without a terminal).")
@json_option
@graph_options(ros=False, allow=TOOL_ALLOW)
def monitor(once: bool, as_json: bool, graph: GraphOptions) -> int:
    """Monitor the boards of all bridges on the graph, with their topics and problems.

    IN/s and OUT/s are bytes per second, DROPS messages lost to a full queue, BAD frames with a wrong
    checksum, RECON reconnects, RTT the shortest round trip, CLOCK the offset of the board's clock. -> is a
    topic that the board publishes, <- one that it subscribes to, => a service it offers, <= one it calls. The
    data comes from /diagnostics, which `rostether serve` publishes.
    """
    is_terminal = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    return run(_monitor(once or not (is_terminal or as_json), as_json, graph))


async def _monitor(once: bool, as_json: bool, graph: GraphOptions) -> int:
    environment = read_environment(graph)
    seen = BoardsSeen()
    async with joined(graph, purpose="monitor") as node:
        listening = asyncio.get_running_loop().create_task(_listen(node, seen, tells=as_json and not once))
        try:
            if once:
                return await _print_once(node, seen, as_json)
            if as_json:
                await listening
            else:
                await _show_live(seen, environment.master_uri, listening)
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
    return EXIT_DONE


async def _listen(graph: TypedGraph, seen: BoardsSeen, *, tells: bool) -> None:
    loop = asyncio.get_running_loop()
    async with aclosing(aiter(graph.messages(TOPIC, TYPE, queue_size=2 * MAX_BOARDS))) as arrays:
        async for array in arrays:
            for status in read_statuses(array):
                seen.add_status(status, loop.time())
                if tells:
                    write_json(asdict(status))


async def _print_once(graph: TypedGraph, seen: BoardsSeen, as_json: bool) -> int:
    loop = asyncio.get_running_loop()
    began_s = loop.time()
    while (waited_s := loop.time() - began_s) < ONCE_S:
        await asyncio.sleep(REFRESH_S / 5)
        expected = len(await _tellers(graph))
        if expected and seen.known_count() >= expected:
            break
        if not expected and waited_s >= NOBODY_S:
            break
    boards = sorted(seen.boards(loop.time()), key=lambda board: board.name)
    if not boards:
        warn(NOTHING)
        return EXIT_FAILED
    if as_json:
        for board in boards:
            write_json(asdict(board))
    else:
        for line in table(boards, shutil.get_terminal_size().columns):
            write_line(line.text)
    return EXIT_DONE


async def _tellers(graph: TypedGraph) -> Sequence[str]:
    """Return the nodes that publish /diagnostics."""
    topic = (await graph.snapshot()).topics.get(TOPIC)
    return topic.publishers if topic is not None else ()


async def _show_live(seen: BoardsSeen, master_uri: str, listening: asyncio.Task[None]) -> None:
    from rich.console import Console
    from rich.live import Live

    console = Console()
    loop = asyncio.get_running_loop()
    with Live(console=console, auto_refresh=False) as live:
        while not listening.done():
            boards = seen.boards(loop.time())
            live.update(_picture(boards, master_uri, console.width, console.height), refresh=True)
            # The end of the subscription also ends the display, at once.
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(asyncio.shield(listening), REFRESH_S)


def _picture(boards: Sequence[BoardStatus], master_uri: str, width: int, height: int) -> Text:
    from rich.text import Text

    if not boards:
        return Text(f"{master_uri}: {NOTHING}; press Ctrl-C to stop")
    text = Text(no_wrap=True, overflow="crop", end="")
    count = f"{len(boards)} board{'' if len(boards) == 1 else 's'}"
    for line in table(boards, width, height - 3):
        for piece, style in line.pieces:
            text.append(piece, style)
        text.append("\n")
    return text.append(f"{count} at {master_uri}; press Ctrl-C to stop"[:width], "dim")


def _gone(status: BoardStatus, silence_s: float) -> BoardStatus:
    return replace(
        status,
        state="gone",
        level=2,
        connected_s=None,
        received_bytes_s=0.0,
        sent_bytes_s=0.0,
        endpoints=tuple(replace(each, rate_hz=0.0) for each in status.endpoints),
        findings=(
            f"nothing on {TOPIC} for {silence_s:.0f} s: the board was unplugged, or its bridge has stopped",
        ),
    )
