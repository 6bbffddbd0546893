"""The scale of a plot's axis: a range with a margin around the values, and ticks at round numbers."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable

from msgspec import Struct

# The margin above and below the values, as a fraction of their range.
_MARGIN = 0.05

# Below this, floats have fewer digits.
_MIN_MARGIN = 1e-300
_LARGEST = 1e308

# Bounds the steps in a range where a step is smaller than the resolution of a float.
_MAX_TICKS = 50
_STEPS = (1.0, 2.0, 5.0, 10.0)
_CLOCK_STEPS_S = (1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400)


class Axis(Struct, frozen=True):
    """A range of values, never empty."""

    low: float
    high: float

    @classmethod
    def around(cls, values: Iterable[float]) -> Axis:
        """Return the range of the finite values with a margin; -1 to 1 if there are none."""
        finite = [min(max(each, -_LARGEST), _LARGEST) for each in values if math.isfinite(each)]
        if not finite:
            return cls(-1.0, 1.0)
        low, high = min(finite), max(finite)
        # Halves, because the difference of two large values may be infinite.
        margin = (high / 2 - low / 2) * 2 * _MARGIN
        if margin < _MIN_MARGIN:
            margin = max(abs(low) * _MARGIN, 0.5)
        return cls(max(low - margin, -_LARGEST), min(high + margin, _LARGEST))

    def part(self, value: float) -> float:
        """Return the position of a value: 0 at the low end, 1 at the high end; it may be outside the axis."""
        return (value / 2 - self.low / 2) / (self.high / 2 - self.low / 2)

    def ticks(self, count: int) -> list[tuple[float, str]]:
        """Return about `count` round values with their texts, ascending."""
        width = self.high / 2 - self.low / 2
        step = _round_step(2 * (width / max(count, 1)))
        first = math.ceil(self.low / step)
        found = []
        for number in range(min(_MAX_TICKS, math.floor(self.high / step) - first + 1)):
            value = (first + number) * step
            found.append((value, _text(value, step)))
        return found


def clock_ticks(axis: Axis, count: int, begin_s: float) -> list[tuple[float, str]]:
    """Return about `count` times with the local time as text; `begin_s` is the Unix time at 0 s.

    Ticks are at whole seconds, minutes or hours of the local time.
    """
    min_step = (axis.high - axis.low) / max(count, 1)
    step = next((each for each in _CLOCK_STEPS_S if each >= min_step), _CLOCK_STEPS_S[-1])
    # A whole hour of local time is not always a whole hour of UTC.
    offset_s = time.localtime(begin_s).tm_gmtoff
    first = math.ceil((begin_s + offset_s + axis.low) / step)
    found = []
    for number in range(_MAX_TICKS):
        moment_s = (first + number) * step - offset_s
        if moment_s - begin_s > axis.high:
            break
        found.append((moment_s - begin_s, time.strftime("%H:%M:%S", time.localtime(moment_s))))
    return found


def _round_step(min_step: float) -> float:
    size = 10.0 ** math.floor(math.log10(min_step))
    return next(size * each for each in _STEPS if size * each >= min_step * (1 - 1e-9))


def _text(value: float, step: float) -> str:
    if value and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.4g}"
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return f"{value + 0.0:.{min(decimals, 12)}f}"
