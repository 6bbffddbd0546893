"""The demo in a terminal of any size: a table of topics with curves, the link, the log, and commands."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING

from rich.console import Console, ConsoleOptions, RenderResult
from rich.rule import Rule
from rich.table import Column, Table
from rich.text import Text

from rostether.cli.demo.view import DemoFacts, DemoView

if TYPE_CHECKING:
    from rostether.bridge.health.diagnostics import BoardView, EndpointView

KEYS = "Keys: l LED, arrows obstacle, q quit"
# Columns that a narrower terminal leaves out, in characters; the curve stays in all of them.
_TYPE_FROM_WIDTH = 100
_RATE_FROM_WIDTH = 50
_COUNT_FROM_WIDTH = 76
_NAME_WIDTH = 15
_VALUE_WIDTH = 13
_TYPE_WIDTH = 18
_RATE_WIDTH = 5
_COUNT_WIDTH = 8
_INDENT = "  "


class DemoScreen:
    """Draws a view that fits the terminal."""

    def __init__(self, facts: DemoFacts, view: DemoView, log: Sequence[str]) -> None:
        self._facts = facts
        self._view = view
        self._log = log

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Yield the lines, for rich."""
        width = options.max_width
        board = self._view.board
        endpoints = board.endpoints if board is not None else ()
        foot = list(self._foot())
        # The title, the table's head, the link's line, and the empty line above the foot.
        height = len(endpoints) + 4 + sum(ceil(len(line) / width) or 1 for line in foot)
        # The cursor needs the last line of the terminal.
        room = max(0, console.size.height - 1 - height)
        yield Rule(f"[bold]{self._facts.title}")
        yield self._table(endpoints, width)
        yield Text(_link(board, width), no_wrap=True, overflow="ellipsis")
        for line in list(self._log)[-room:] if room else ():
            yield Text(line, style="dim", no_wrap=True, overflow="ellipsis")
        yield ""
        for line in foot:
            # Long commands are continued at the left edge, so that they can be copied.
            yield Text(line, overflow="fold")

    def _foot(self) -> Sequence[str]:
        facts = self._facts
        return [
            f"{KEYS}, Ctrl-C stop" if facts.has_keys else "Press Ctrl-C to stop",
            *((f"Dashboard: {facts.dashboard_url}",) if facts.dashboard_url else ()),
            "In a second terminal:",
            *(f"{_INDENT}{step}" for step in facts.next_steps()),
        ]

    def _table(self, endpoints: Sequence[EndpointView], width: int) -> Table:
        columns = [Column("topic", width=_NAME_WIDTH, no_wrap=True)]
        if has_type := width >= _TYPE_FROM_WIDTH:
            columns.append(Column("type", width=_TYPE_WIDTH, no_wrap=True, style="cyan"))
        if has_rate := width >= _RATE_FROM_WIDTH:
            columns.append(Column("Hz", width=_RATE_WIDTH, justify="right"))
        if has_count := width >= _COUNT_FROM_WIDTH:
            columns.append(Column("messages", width=_COUNT_WIDTH, justify="right"))
        columns.append(Column("value", width=_VALUE_WIDTH, no_wrap=True, style="green"))
        columns.append(Column("", ratio=1, no_wrap=True, style="green", overflow="crop"))
        # Two spaces between columns.
        room = width - sum(column.width or 0 for column in columns) - 2 * (len(columns) - 1)
        table = Table(*columns, expand=True, box=None, pad_edge=False, padding=(0, 2, 0, 0), show_edge=False)
        for endpoint in endpoints:
            is_topic = endpoint.role in ("publisher", "subscriber")
            cells = [f"{_arrow(endpoint.role)} {endpoint.name}"]
            cells += [endpoint.type] if has_type else []
            cells += [f"{self._view.rate_hz(endpoint):.1f}" if is_topic else ""] if has_rate else []
            cells += [str(endpoint.message_count) if is_topic else ""] if has_count else []
            cells.append(self._view.value(endpoint) if is_topic else "service")
            table.add_row(*cells, self._view.curve(endpoint, room))
        return table


def _arrow(role: str) -> str:
    return {"publisher": "->", "subscriber": "<-"}.get(role, "  ")


def _link(board: BoardView | None, width: int) -> str:
    """Return the state of the link, the more important facts first, as many as fit."""
    if board is None or not board.is_connected:
        return "link: waiting for the board"
    facts = [
        f"link: {'negotiated' if board.is_settled else 'negotiating'}",
        f"{board.received_frames} frames",
        f"{board.discarded_frames} damaged",
        f"{board.reset_count} resets",
        f"{board.received_bytes / 1000:.0f} kB in",
        f"{board.sent_bytes / 1000:.1f} kB out",
        board.peer,
    ]
    while len(facts) > 1 and len(", ".join(facts)) > width:
        facts.pop()
    return ", ".join(facts)
