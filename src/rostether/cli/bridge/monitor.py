"""`rostether monitor`: all boards and their topics at a glance, from /diagnostics."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
from collections.abc import Sequence
from typing import TYPE_CHECKING

from msgspec import to_builtins

from rostether.bridge.health.board_status import BoardStatus
from rostether.bridge.health.reported_boards import SeenBoards, listen, reported_boards
from rostether.cli.access.either_graph import joined_either
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.bridge.monitor_table import table
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import add_flag
from rostether.cli.shell.output import json_option, shows_live, warn, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.text import counted

if TYPE_CHECKING:
    from rich.text import Text

    from rostether.graph.typed_graph import TypedGraph

# Boards report once a second; half of that shows new values early enough.
REFRESH_S = 0.5

NOTHING = (
    "no board publishes on /diagnostics; start `rostether serve` on this graph (without --no-diagnostics) "
    "and connect a board"
)


@verb(
    "monitor",
    """
    rostether monitor                     live, until Ctrl-C
    rostether monitor --once              one table
    rostether monitor --once --json       an object for each board
    rostether monitor --json              the same every second
    rostether monitor --ros2              the boards on a ROS 2 graph
    """,
)
@add_flag("--once", "Print one table and exit (the default without a terminal).")
@json_option
@graph_options(allow=True)
async def monitor(once: bool, as_json: bool, graph: GraphOptions) -> int:
    """Monitor the boards of all bridges on the graph, with their topics and problems.

    UP is the time since the board connected. IN/s and OUT/s are bytes per second. DROPS counts messages lost
    to a full queue, BAD frames with a wrong checksum, and RECON reconnects. RTT is the shortest round trip,
    and CLOCK the offset of the board's clock. -> is a topic that the board publishes, <- one that it
    subscribes to, => a service it offers, <= one it calls. The data comes from /diagnostics, which
    `rostether serve` publishes.
    """
    async with joined_either(graph, purpose="monitor") as (node, graph_name):
        if once or not (shows_live() or as_json):
            return await _print_once(node, as_json)
        if as_json:
            await listen(node, _write_status)
            return EXIT_DONE
        seen = SeenBoards(asyncio.get_running_loop().time)
        async with task_beside(listen(node, seen.add_status)) as listening:
            await _show_live(seen, graph_name, listening)
    return EXIT_DONE


def _write_status(status: BoardStatus) -> None:
    write_json(to_builtins(status))


async def _print_once(node: TypedGraph, as_json: bool) -> int:
    boards = await reported_boards(node)
    if not boards:
        warn(NOTHING)
        return EXIT_FAILED
    if as_json:
        for board in boards:
            _write_status(board)
    else:
        for line in table(boards, shutil.get_terminal_size().columns):
            write_line(line.text)
    return EXIT_DONE


async def _show_live(seen: SeenBoards, graph_name: str, listening: asyncio.Task[object]) -> None:
    from rich.console import Console
    from rich.live import Live

    console = Console()
    with Live(console=console, auto_refresh=False) as live:
        while not listening.done():
            boards = seen.boards()
            live.update(_picture(boards, graph_name, console.width, console.height), refresh=True)
            # The end of the subscription also ends the display, immediately.
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(asyncio.shield(listening), REFRESH_S)


def _picture(boards: Sequence[BoardStatus], graph_name: str, width: int, height: int) -> Text:
    from rich.text import Text

    if not boards:
        return Text(f"{graph_name}: {NOTHING}; press Ctrl-C to stop")
    text = Text(no_wrap=True, overflow="crop", end="")
    count = counted(len(boards), "board")
    # The line below the table and the cursor need room: a full screen would scroll.
    for line in table(boards, width, height - 3):
        for piece, style in line.pieces:
            text.append(piece, style)
        text.append("\n")
    return text.append(f"{count} on {graph_name}; press Ctrl-C to stop"[:width], "dim")
