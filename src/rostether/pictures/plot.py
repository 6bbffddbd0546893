"""Curves over time as a scene: axes with round numbers, a grid, and a legend."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rostether.pictures.axis import Axis
from rostether.pictures.scene import Anchor, Color, Point, Scene, rectangle, text_width

# Okabe and Ito's colors without yellow, which is invisible on white paper; color-blind people can distinguish
# them.
COLORS: Sequence[Color] = (
    (0, 114, 178),
    (213, 94, 0),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (230, 159, 0),
    (90, 90, 90),
)
_INK: Color = (40, 44, 52)
_GRID: Color = (226, 229, 234)
_SIZE = 11.0
_TICK_HEIGHT = 36.0  # pixels between marks, at least
_TICK_WIDTH = 90.0
_LEGEND_ROW = 16.0
_MARGIN = 14.0


@dataclass(frozen=True, slots=True)
class Curve:
    """One value over time: (seconds, value), times ascending; values that are not finite are gaps."""

    name: str
    points: Sequence[Point]


def draw_plot(curves: Sequence[Curve], *, width: int = 900, height: int = 480) -> Scene:
    """Draw the curves over the time in which they have values; the legend adds to the height."""
    times = [time for curve in curves for time, _ in curve.points]
    across = Axis(min(times), max(times)) if times and min(times) < max(times) else Axis.around(times)
    up = Axis.around([value for curve in curves for _, value in curve.points])
    up_ticks = up.ticks(max(2, int(height / _TICK_HEIGHT)))
    left = _MARGIN + max((text_width(text, _SIZE) for _, text in up_ticks), default=0.0) + 8
    right, top = width - _MARGIN, _MARGIN + len(curves) * _LEGEND_ROW + 4
    bottom = top + height - 3 * _MARGIN
    scene = Scene(width, math.ceil(bottom + 3 * _MARGIN))
    for value, text in up_ticks:
        y = bottom - up.part(value) * (bottom - top)
        scene.line([(left, y), (right, y)], _GRID)
        scene.text(left - 6, y + _SIZE * 0.3, text, _SIZE, _INK, Anchor.END)
    for value, text in across.ticks(max(2, int((right - left) / _TICK_WIDTH))):
        x = left + across.part(value) * (right - left)
        scene.line([(x, top), (x, bottom)], _GRID)
        scene.text(x, bottom + _SIZE + 5, text, _SIZE, _INK, Anchor.MIDDLE)
    scene.text((left + right) / 2, bottom + 2 * _SIZE + 10, "seconds", _SIZE, _INK, Anchor.MIDDLE)
    frame = rectangle(left, top, right - left, bottom - top)
    scene.line([*frame, frame[0]], _INK)
    for number, curve in enumerate(curves):
        color = COLORS[number % len(COLORS)]
        y = _MARGIN + number * _LEGEND_ROW
        scene.line([(left, y), (left + 24, y)], color, 2.5)
        scene.text(left + 32, y + _SIZE * 0.3, curve.name, _SIZE, _INK)
        for points in pieces(curve.points):
            placed = [
                (left + across.part(time) * (right - left), bottom - up.part(value) * (bottom - top))
                for time, value in points
            ]
            _draw_piece(scene, _thinned(placed), color)
    return scene


def pieces(points: Sequence[Point]) -> Iterator[list[Point]]:
    """Yield the parts of a curve between its gaps."""
    piece: list[Point] = []
    for point in points:
        if math.isfinite(point[1]):
            piece.append(point)
        elif piece:
            yield piece
            piece = []
    if piece:
        yield piece


def _draw_piece(scene: Scene, points: list[Point], color: Color) -> None:
    if len(points) == 1:
        (x, y), reach = points[0], 2.0
        scene.area(rectangle(x - reach, y - reach, 2 * reach, 2 * reach), color, color)
    else:
        scene.line(points, color, 1.6)


def _thinned(points: list[Point]) -> list[Point]:
    """Return at most four points a pixel column, first, lowest, highest and last: nothing seen is lost."""
    if len(points) < 3:
        return points
    columns: list[list[Point]] = [[points[0]]]
    for before, point in pairwise(points):
        if int(before[0]) == int(point[0]):
            columns[-1].append(point)
        else:
            columns.append([point])
    kept: list[Point] = []
    for column in columns:
        places = {0, len(column) - 1}
        places.add(min(range(len(column)), key=lambda place: column[place][1]))
        places.add(max(range(len(column)), key=lambda place: column[place][1]))
        kept += [column[place] for place in sorted(places)]
    return kept
