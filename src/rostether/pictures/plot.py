"""Curves over time as a scene: axes with round numbers, a grid, and a legend."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from itertools import groupby

from msgspec import Struct

from rostether.pictures.axis import Axis, clock_ticks
from rostether.pictures.scene import Anchor, Color, Point, Scene, rectangle, text_width

# The colors of Okabe and Ito, which color-blind people can distinguish, without yellow, which is invisible on
# white paper.
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
# All sizes are in pixels; the size of a tick is its minimum distance from the next one.
_SIZE = 11.0
_WIDTH, _HEIGHT = 900, 480
_TICK_HEIGHT = 36.0
_TICK_WIDTH = 90.0
_LEGEND_ROW = 16.0
_TITLE_SIZE = 14.0
_TITLE_ROW = 24.0
_MARGIN = 14.0


class Curve(Struct, frozen=True):
    """One value over time: (seconds, value), times ascending. A value that is not finite is a gap."""

    name: str
    points: Sequence[Point]
    unit: str = ""
    # Whether it uses the scale at the right.
    is_right: bool = False

    @property
    def label(self) -> str:
        """The name with the unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


class Labels(Struct, frozen=True):
    """The text around a plot; `begin_s` is the Unix time at 0 s."""

    title: str = ""
    begin_s: float | None = None
    shows_time_of_day: bool = False


class _Frame(Struct, frozen=True):
    left: float
    right: float
    top: float
    bottom: float
    x_axis: Axis

    def x(self, time_s: float) -> float:
        return self.left + self.x_axis.part(time_s) * (self.right - self.left)

    def y(self, axis: Axis, value: float) -> float:
        return self.bottom - axis.part(value) * (self.bottom - self.top)


def draw_plot(curves: Sequence[Curve], labels: Labels | None = None) -> Scene:
    """Draw the curves over the time in which they have values."""
    labels = labels or Labels()
    times = [time_s for curve in curves for time_s, _ in curve.points]
    x_axis = Axis(min(times), max(times)) if times and min(times) < max(times) else Axis.around(times)
    sides = {is_right: [each for each in curves if each.is_right is is_right] for is_right in (False, True)}
    axes = {
        is_right: Axis.around([value for curve in group for _, value in curve.points])
        for is_right, group in sides.items()
        if group or not is_right
    }
    count = max(2, int(_HEIGHT / _TICK_HEIGHT))
    margins = {
        is_right: max((text_width(text, _SIZE) for _, text in axis.ticks(count)), default=0.0) + 8
        for is_right, axis in axes.items()
    }
    legend_top = _MARGIN + (_TITLE_ROW if labels.title else 0.0)
    has_units = any(curve.unit for curve in curves)
    top = legend_top + len(curves) * _LEGEND_ROW + (_LEGEND_ROW if has_units else 4)
    frame = _Frame(
        _MARGIN + margins[False],
        _WIDTH - _MARGIN - margins.get(True, 0.0),
        top,
        top + _HEIGHT - 3 * _MARGIN,
        x_axis,
    )
    scene = Scene(_WIDTH, math.ceil(frame.bottom + 3 * _MARGIN))
    if labels.title:
        scene.text(_WIDTH / 2, _MARGIN + _TITLE_SIZE * 0.5, labels.title, _TITLE_SIZE, _INK, Anchor.MIDDLE)
    for is_right, axis in axes.items():
        _draw_scale(scene, frame, axis, sides[is_right], count, is_right=is_right)
    _draw_times(scene, frame, labels)
    edge = rectangle(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top)
    scene.line([*edge, edge[0]], _INK)
    for number, curve in enumerate(curves):
        color = COLORS[number % len(COLORS)]
        y = legend_top + number * _LEGEND_ROW
        scene.line([(frame.left, y), (frame.left + 24, y)], color, 2.5)
        where = " (right scale)" if curve.is_right else ""
        scene.text(frame.left + 32, y + _SIZE * 0.3, curve.label + where, _SIZE, _INK)
        for points in pieces(curve.points):
            placed = [(frame.x(time_s), frame.y(axes[curve.is_right], value)) for time_s, value in points]
            _draw_piece(scene, _thinned(placed), color)
    return scene


def _draw_scale(
    scene: Scene, frame: _Frame, axis: Axis, curves: Sequence[Curve], count: int, *, is_right: bool
) -> None:
    x, anchor = (frame.right + 6, Anchor.START) if is_right else (frame.left - 6, Anchor.END)
    for value, text in axis.ticks(count):
        y = frame.y(axis, value)
        if not is_right:
            scene.line([(frame.left, y), (frame.right, y)], _GRID)
        scene.text(x, y + _SIZE * 0.3, text, _SIZE, _INK, anchor)
    units = ", ".join(dict.fromkeys(curve.unit for curve in curves if curve.unit))
    if units:
        x, anchor = (frame.right, Anchor.END) if is_right else (frame.left, Anchor.START)
        scene.text(x, frame.top - 5, units, _SIZE, _INK, anchor)


def _draw_times(scene: Scene, frame: _Frame, labels: Labels) -> None:
    count = max(2, int((frame.right - frame.left) / _TICK_WIDTH))
    ticks, name = frame.x_axis.ticks(count), "seconds"
    if labels.begin_s is not None:
        begin = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(labels.begin_s))
        name = f"seconds since {begin}"
        if labels.shows_time_of_day:
            ticks, name = clock_ticks(frame.x_axis, count, labels.begin_s), begin.partition(" ")[0]
    for value, text in ticks:
        x = frame.x(value)
        scene.line([(x, frame.top), (x, frame.bottom)], _GRID)
        scene.text(x, frame.bottom + _SIZE + 5, text, _SIZE, _INK, Anchor.MIDDLE)
    middle = (frame.left + frame.right) / 2
    scene.text(middle, frame.bottom + 2 * _SIZE + 10, name, _SIZE, _INK, Anchor.MIDDLE)


def pieces(points: Sequence[Point]) -> Iterator[list[Point]]:
    """Yield the parts of a curve between its gaps."""
    for is_finite, piece in groupby(points, key=lambda point: math.isfinite(point[1])):
        if is_finite:
            yield list(piece)


def _draw_piece(scene: Scene, points: list[Point], color: Color) -> None:
    if len(points) == 1:
        (x, y), reach = points[0], 2.0
        scene.area(rectangle(x - reach, y - reach, 2 * reach, 2 * reach), color, color)
    else:
        scene.line(points, color, 1.6)


def _thinned(points: list[Point]) -> list[Point]:
    """Return at most four points per pixel column (first, lowest, highest, last), which look the same."""
    if len(points) < 3:
        return points
    kept: list[Point] = []
    for _, run in groupby(points, key=lambda point: int(point[0])):
        column = list(run)
        indexes = {0, len(column) - 1}
        indexes.add(min(range(len(column)), key=lambda index: column[index][1]))
        indexes.add(max(range(len(column)), key=lambda index: column[index][1]))
        kept += [column[index] for index in sorted(indexes)]
    return kept
