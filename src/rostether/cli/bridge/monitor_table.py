"""The table of `rostether monitor`: one row for each board, with its topics and problems below."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Literal, TypeAlias

from msgspec import Struct

from rostether.bridge.health.board_status import BoardStatus, EndpointStatus
from rostether.mechanisms.text import counted

Style: TypeAlias = Literal["", "bold", "dim", "green", "yellow", "bold red"]

# In characters, for a name, a state and a column. Narrower terminals cut the lines.
_MIN_WIDTH = 40
# Room for `/serial_node_2`, and for a name that contains the id of a USB device.
_NAME_MIN = 15
_NAME_MAX = 40
# From this width on, the totals fit beside the rates.
_WIDE = 100
_ARROWS = {"publisher": "->", "subscriber": "<-", "service server": "=>", "service client": "<="}
_STATE_STYLES: dict[str, Style] = {"connected": "green", "disconnected": "bold red", "gone": "bold red"}
# A level of diagnostic_msgs/DiagnosticStatus.
_ERROR = 2


class Line(Struct, frozen=True):
    """One line of the table: pieces of text, each in a style."""

    pieces: tuple[tuple[str, Style], ...]

    @property
    def text(self) -> str:
        """The line without styles."""
        return "".join(text for text, _ in self.pieces).rstrip()


class _Column(Struct, frozen=True):
    title: str
    width: int
    text: Callable[[BoardStatus], str]
    is_count_of_faults: bool = False


_COLUMNS = (
    _Column("UP", 7, lambda board: duration(board.connected_s)),
    _Column("IN/s", 5, lambda board: amount(board.received_bytes_s)),
    _Column("OUT/s", 5, lambda board: amount(board.sent_bytes_s)),
    _Column("DROPS", 5, lambda board: amount(board.dropped_count), True),
    _Column("BAD", 5, lambda board: amount(board.checksum_errors), True),
    _Column("RECON", 5, lambda board: amount(board.reconnects)),
    _Column("RTT ms", 6, lambda board: _milliseconds(board.round_trip_ms)),
    _Column("CLOCK", 7, lambda board: _offset(board.clock_offset_ms)),
)
_TOTALS = (
    _Column("IN", 5, lambda board: amount(board.received_bytes)),
    _Column("OUT", 5, lambda board: amount(board.sent_bytes)),
)
# As wide as `negotiating`.
_STATE_WIDTH = 11


class _Layout(Struct, frozen=True):
    """The columns that fit beside names and states, and the widths of names and lines in characters."""

    columns: Sequence[_Column]
    name_width: int
    width: int


def table(boards: Sequence[BoardStatus], width: int, height: int | None = None) -> list[Line]:
    """Return the lines of the table, at most `height` of `width` characters.

    Topics are omitted first, then problems, then boards.
    """
    width = max(width, _MIN_WIDTH)
    boards = sorted(boards, key=lambda board: _natural(board.name))
    columns = _fitting(_COLUMNS + (_TOTALS if width >= _WIDE else ()), width)
    layout = _Layout(columns, _name_width(boards, columns, width), width)
    head = _head(layout)
    lines = [head, *(line for board in boards for line in _block(board, layout))]
    if height is None or len(lines) <= height:
        return lines
    briefs = [line for board in boards for line in _brief(board, layout)]
    rows = [_row(board, layout) for board in boards]
    # The head and the hint need a line each.
    room = max(height - 2, 0)
    if len(briefs) <= room:
        more = "topics are not shown"
    elif len(rows) <= room:
        briefs, more = rows, "problems and topics are not shown"
    else:
        briefs, more = rows[:room], f"... and {counted(len(rows) - room, 'more board')}"
    hint = _cut(f"{more}; use a taller window or --once to show all", width)
    return [head, *briefs, Line(((hint, "dim"),))]


def duration(seconds: float | None) -> str:
    """Return `42s`, `5m03s`, `2h07m` or `3d04h`; `-` for None."""
    if seconds is None:
        return "-"
    whole = int(seconds)
    for size, unit, smaller, small_unit in ((86400, "d", 3600, "h"), (3600, "h", 60, "m"), (60, "m", 1, "s")):
        if whole >= size:
            return f"{whole // size}{unit}{whole % size // smaller:02}{small_unit}"
    return f"{whole}s"


def amount(number: float) -> str:
    """Return a number of bytes or messages in at most five characters: `999`, `1.2k`, `34M`."""
    for unit in ("", "k", "M", "G"):
        if number < 9.95 and unit:
            return f"{number:.1f}{unit}"
        if number < 999.5:
            return f"{number:.0f}{unit}"
        number /= 1000
    return f"{number:.0f}T"


def _fitting(columns: Sequence[_Column], width: int) -> Sequence[_Column]:
    """Return the first columns, as many as fit beside a name and a state."""
    kept: list[_Column] = []
    left = width - _NAME_MIN - 1 - _STATE_WIDTH
    for column in columns:
        left -= column.width + 1
        if left < 0:
            break
        kept.append(column)
    return kept


def _name_width(boards: Iterable[BoardStatus], columns: Sequence[_Column], width: int) -> int:
    taken = _STATE_WIDTH + 1 + sum(column.width + 1 for column in columns)
    longest = max((len(board.name) for board in boards), default=0)
    return max(_NAME_MIN, min(longest, width - taken, _NAME_MAX))


def _head(layout: _Layout) -> Line:
    cells = " ".join(f"{column.title:>{column.width}}" for column in layout.columns)
    text = f"{'BOARD':{layout.name_width}} {'STATE':{_STATE_WIDTH}} {cells}"
    return Line(((_cut(text, layout.width), "bold"),))


def _block(board: BoardStatus, layout: _Layout) -> list[Line]:
    """Return a board's row, its topics and services, and its findings."""
    row, *findings = _brief(board, layout)
    longest = max((len(each.name) for each in board.endpoints), default=0)
    # A type and a rate need the other half of the line.
    name_width = min(longest, layout.width // 2 - 8)
    endpoints = sorted(board.endpoints, key=lambda each: (not each.is_topic, each.name, each.role))
    return [row, *(_endpoint(each, name_width, layout.width) for each in endpoints), *findings]


def _brief(board: BoardStatus, layout: _Layout) -> list[Line]:
    """Return a board's row and its findings, each wrapped over several lines if it is long."""
    from textwrap import wrap

    style: Style = "bold red" if board.level >= _ERROR else "yellow"
    findings = [
        Line(((part, style),))
        for text in board.findings
        for part in wrap(text, layout.width, initial_indent="   ! ", subsequent_indent="     ")
    ]
    return [_row(board, layout), *findings]


def _row(board: BoardStatus, layout: _Layout) -> Line:
    # "disconnected" is wider than its column.
    state = "away" if board.state == "disconnected" else board.state
    pieces: list[tuple[str, Style]] = [
        (f"{_cut_middle(board.name, layout.name_width):{layout.name_width}} ", "bold"),
        (f"{_cut(state, _STATE_WIDTH):{_STATE_WIDTH}}", _STATE_STYLES.get(board.state, "yellow")),
    ]
    for column in layout.columns:
        text = column.text(board)
        is_bad = column.is_count_of_faults and text != "0"
        pieces.append((f" {text:>{column.width}}", "yellow" if is_bad else ""))
    return _fit(pieces, layout.width)


def _endpoint(endpoint: EndpointStatus, name_width: int, width: int) -> Line:
    name = _cut_middle(endpoint.name, name_width)
    if endpoint.is_topic:
        rate = f"{endpoint.rate_hz:.1f} Hz"
    else:
        rate = f"{amount(endpoint.message_count)} call{'' if endpoint.message_count == 1 else 's'}"
    lost = f"  {amount(endpoint.dropped_count)} lost" if endpoint.dropped_count else ""
    # The arrow, the rate and the losses need 32 characters.
    type_width = min(28, max(0, width - name_width - 32))
    return _fit(
        [
            (f"   {_ARROWS.get(endpoint.role, '  ')} {name:{name_width}}  ", ""),
            (f"{_cut(endpoint.type, type_width):{type_width}}", "dim"),
            (f"  {rate:>10}", ""),
            (lost, "yellow"),
        ],
        width,
    )


def _milliseconds(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.1f}" if value < 1000 else f"{value:.0f}"


def _offset(value_ms: float | None) -> str:
    if value_ms is None:
        return "-"
    if abs(value_ms) < 1000:
        return f"{value_ms:+.1f}ms" if abs(value_ms) < 100 else f"{value_ms:+.0f}ms"
    return f"{value_ms / 1000:+.1f}s" if abs(value_ms) < 1e6 else f"{value_ms / 1000:+.0e}s"


def _fit(pieces: Sequence[tuple[str, Style]], width: int) -> Line:
    kept: list[tuple[str, Style]] = []
    left = width
    for text, style in pieces:
        if text and left > 0:
            kept.append((text[:left], style))
            left -= len(text)
    return Line(tuple(kept))


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: max(width - 2, 0)]}.."


def _cut_middle(name: str, width: int) -> str:
    """Return a name that fits, without its middle: long names mostly differ at the end."""
    if len(name) <= width:
        return name
    tail = (width - 2) * 2 // 3
    return f"{name[: width - 2 - tail]}..{name[len(name) - tail :]}"


def _natural(name: str) -> list[tuple[str, int]]:
    """Return a sort key that puts board_2 before board_10."""
    return [(text, int(number or 0)) for text, number in re.findall(r"(\D*)(\d{0,9})", name)]
