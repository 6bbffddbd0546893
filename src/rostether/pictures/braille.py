"""Curves in a terminal: each character is a Unicode braille pattern of 2 x 4 dots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rostether.pictures.axis import Axis
from rostether.pictures.plot import Curve, pieces
from rostether.pictures.scene import Point

_BLANK = 0x2800
# The bit of the dot in each row, left and right. Source: Unicode, block Braille Patterns.
_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))

# The limit of coordinates, in dots; points farther outside are moved to it.
_FAR = 1 << 20


def braille(
    curves: Sequence[Curve], columns: int, rows: int, x_axis: Axis, y_axis: Axis
) -> list[list[tuple[str, int | None]]]:
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
