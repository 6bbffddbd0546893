"""A plot in the terminal: curves of braille dots, round numbers at the axes, names with the last values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from rostether.mechanisms.text import escape_line
from rostether.pictures.axis import Axis, clock_ticks
from rostether.pictures.plot import COLORS, Curve, pieces
from rostether.pictures.scene import Point

if TYPE_CHECKING:
    from rich.text import Text

# In a smaller area, curves are not recognizable.
_MIN_COLUMNS, _MIN_ROWS = 20, 4

# Bounds the work for terminals that report a huge width.
_MAX_COLUMNS = 400

# Each character is a braille pattern of 2 x 4 dots.
_BLANK = 0x2800
# The bit of the dot in each row, left and right. Source: Unicode, block Braille Patterns.
_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))

# The limit of coordinates, in dots; points farther outside are moved to it.
_FAR = 1 << 20

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


def braille(
    curves: Sequence[Curve], columns: int, rows: int, x_axis: Axis, y_axis: Axis
) -> list[list[Piece]]:
    """Return rows of cells, top first: a character and the index of the last curve drawn there."""
    dots = [[0] * columns for _ in range(rows)]
    owners: list[list[int | None]] = [[None] * columns for _ in range(rows)]
    for number, curve in enumerate(curves):
        for points in pieces(curve.points):
            placed = [_dot(point, columns, rows, x_axis, y_axis) for point in points]
            for start, end in zip(placed, placed[1:] or placed, strict=False):
                for x, y in _dots_between(start, end, (2 * columns, 4 * rows)):
                    dots[y // 4][x // 2] |= _BITS[y % 4][x % 2]
                    owners[y // 4][x // 2] = number
    return [
        [(chr(_BLANK + dot) if dot else " ", owner) for dot, owner in zip(row, row_owners, strict=True)]
        for row, row_owners in zip(dots, owners, strict=True)
    ]


def _dot(point: Point, columns: int, rows: int, x_axis: Axis, y_axis: Axis) -> tuple[int, int]:
    x = x_axis.part(point[0]) * (2 * columns - 1)
    y = (1 - y_axis.part(point[1])) * (4 * rows - 1)
    return round(min(max(x, -_FAR), _FAR)), round(min(max(y, -_FAR), _FAR))


def _dots_between(
    start: tuple[int, int], end: tuple[int, int], size: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    """Yield the dots of a line that are inside an area of the given size."""
    count = max(abs(end[0] - start[0]), abs(end[1] - start[1]), 1)
    first, last = 0.0, float(count)
    for begin, finish, limit in zip(start, end, size, strict=True):
        distance = finish - begin
        if distance:
            # A point up to half a dot outside is rounded to a dot inside.
            bounds = ((-0.5 - begin) * count / distance, (limit - 0.5 - begin) * count / distance)
            first, last = max(first, min(bounds)), min(last, max(bounds))
    for step in range(math.floor(first), math.ceil(last) + 1):
        x = round(start[0] + (end[0] - start[0]) * step / count)
        y = round(start[1] + (end[1] - start[1]) * step / count)
        if 0 <= x < size[0] and 0 <= y < size[1]:
            yield x, y
