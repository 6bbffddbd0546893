"""The curves of `rostether plot`: the selected fields, and their values over time."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from typing import Any

from rostether.cli.shell.output import warn
from rostether.pictures.plot import Curve
from rostether.rostime import Duration, Time
from rostether.serde.values import Message

# Four rounds of colors: more cannot be distinguished, and a laser scan has hundreds of ranges.
MAX_CURVES = 28

# Points of all curves: 10 minutes of seven curves at 50 Hz; the oldest are dropped first.
MAX_POINTS = 200_000

# In a plot of a whole message, the large numbers of its count and stamp would hide all others.
_LEFT_OUT = "header"


def expand(argument: str) -> list[str]:
    """Return the fields that an argument names: `/imu/rate/x:y` is /imu/rate/x and /imu/rate/y.

    A colon in brackets selects elements, as in all field paths: `/joints/position[0:2]`.
    """
    parts, depth = [""], 0
    for character in argument:
        depth += (character == "[") - (character == "]")
        if character == ":" and depth <= 0:
            parts.append("")
        else:
            parts[-1] += character
    stem = parts[0].partition("[")[0]
    prefix = stem.rpartition("/")[0]
    return [parts[0], *(f"{prefix}/{part}" for part in parts[1:] if part)]


def numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    """Yield each number in a value with its path, such as `/imu/rate/x` or `/scan/ranges[3]`."""
    if isinstance(value, bool | int | float):
        yield name, float(value)
    elif isinstance(value, Time | Duration):
        yield name, value.to_s()
    elif isinstance(value, bytes | list):
        for index, each in enumerate(value[: MAX_CURVES + 1]):
            yield from numbers(f"{name}[{index}]", each)
    elif isinstance(value, Message):
        for field, _ in value._fields:
            if field != _LEFT_OUT:
                yield from numbers(f"{name}/{field}", getattr(value, field))


class Curves:
    """The values received so far, in the order in which their fields were announced."""

    def __init__(self) -> None:
        self._points: dict[str, dict[str, deque[tuple[float, float]]]] = {}
        self._count = 0
        self._is_full = False

    @property
    def names(self) -> list[str]:
        """The names of the current curves."""
        return [name for group in self._points.values() for name in group]

    def expect(self, *names: str) -> None:
        """Announce the names of fields whose values follow."""
        for name in names:
            self._points.setdefault(name, {})

    def add(self, now_s: float, name: str, value: Any) -> bool:
        """Add a field's value, or the numbers in it; False if there are none."""
        self.expect(name)
        group = self._points[name]
        found = False
        for path, number in numbers(name, value):
            found = True
            if path not in group:
                if self._count >= MAX_CURVES:
                    self._report_full()
                    return True
                self._count += 1
                group[path] = deque()
                self._share_points()
            group[path].append((now_s, number))
        return found

    def curves(self, since_s: float = -math.inf) -> list[Curve]:
        """Return the curves with their points at `since_s` and later, on the clock of `add`."""
        return [
            Curve(name, [point for point in points if point[0] >= since_s])
            for group in self._points.values()
            for name, points in group.items()
        ]

    def _share_points(self) -> None:
        limit = MAX_POINTS // self._count
        for group in self._points.values():
            for name, points in group.items():
                group[name] = deque(points, maxlen=limit)

    def _report_full(self) -> None:
        if not self._is_full:
            self._is_full = True
            warn(f"WARNING: only the first {MAX_CURVES} values are plotted; give fewer fields")
