"""A plot in the terminal: curves of braille dots, round numbers at the axes, names with the last values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from rostether.mechanisms.text import escape_line
from rostether.pictures.axis import Axis, clock_ticks
from rostether.pictures.braille import braille
from rostether.pictures.plot import COLORS, Curve

if TYPE_CHECKING:
    from rich.text import Text

# In a smaller area, curves are not recognizable.
_MIN_COLUMNS, _MIN_ROWS = 20, 4

# Bounds the work for terminals that report a huge width.
_MAX_COLUMNS = 400

# Text, and the index of the curve that gives its color.
Piece = tuple[str, int | None]


def plot_lines(
    curves: Sequence[Curve], columns: int, rows: int, x_axis: Axis, begin_s: float | None = None
) -> list[list[Piece]]:
    """Return the lines of a plot in a window of the given size, as pieces of one color.

    With `begin_s`, the Unix time at 0 s, the ticks are local times.
    """
    y_axis = Axis.around([value for curve in curves for _, value in curve.points])
    legend = _legend(curves, columns)
    height = max(_MIN_ROWS, rows - len(legend) - 2)
    marks = {}
    for value, text in y_axis.ticks(max(2, height // 3)):
        marks[height - 1 - round(y_axis.part(value) * (height - 1))] = text
    margin = max(map(len, marks.values()), default=0) + 1
    width = min(_MAX_COLUMNS, max(_MIN_COLUMNS, columns - margin - 1))
    lines: list[list[Piece]] = []
    for number, cells in enumerate(braille(curves, width, height, x_axis, y_axis)):
        mark = marks.get(number, "")
        lines.append([(f"{mark:>{margin}}{'┤' if mark else '│'}", None), *_joined(cells)])
    lines.append([(" " * margin + "└" + "─" * width, None)])
    lines.append([(" " * (margin + 1) + _x_axis_marks(x_axis, width, begin_s), None)])
    return lines + legend


def as_plain(lines: Sequence[Sequence[Piece]]) -> list[str]:
    """Return the lines without colors."""
    return ["".join(text for text, _ in line).rstrip() for line in lines]


def as_colored(lines: Sequence[Sequence[Piece]], footer: str) -> Text:
    """Return the lines in the curves' colors, and a dim footer."""
    from rich.text import Text

    text = Text(no_wrap=True, overflow="crop", end="")
    for line in lines:
        for piece, number in line:
            text.append(
                piece, "" if number is None else "rgb({},{},{})".format(*COLORS[number % len(COLORS)])
            )
        text.append("\n")
    return text.append(footer, "dim")


def _joined(cells: Sequence[Piece]) -> Iterator[Piece]:
    """Join adjacent cells of one curve, so that each color is sent once."""
    for number, run in groupby(cells, key=lambda cell: cell[1]):
        yield "".join(text for text, _ in run), number


def _legend(curves: Sequence[Curve], columns: int) -> list[list[Piece]]:
    lines: list[list[Piece]] = []
    for number, curve in enumerate(curves):
        last = f"{curve.points[-1][1]:.6g}" if curve.points else "-"
        unit = f" {curve.unit}" if curve.unit else ""
        lines.append([(f"── {escape_line(curve.name)} {last}{unit}"[:columns], number)])
    return lines


def _x_axis_marks(x_axis: Axis, width: int, begin_s: float | None) -> str:
    count = max(2, width // 12)
    if begin_s is None:
        ticks = [(value, f"{text} s") for value, text in x_axis.ticks(count)]
    else:
        ticks = clock_ticks(x_axis, count, begin_s)
    line = [" "] * width
    free_from = 0
    for value, text in ticks:
        start = round(x_axis.part(value) * (width - 1)) - len(text) // 2
        start = min(max(start, 0), width - len(text))
        if start >= free_from:
            line[start : start + len(text)] = text
            free_from = start + len(text) + 1
    return "".join(line).rstrip()
