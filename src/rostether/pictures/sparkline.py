"""A curve in one line of text."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

_BARS = "▁▂▃▄▅▆▇█"


def sparkline(values: Sequence[float], scale: tuple[float, float] | None = None) -> str:
    """Return one character for each value: a bar from the lower end of the scale to the upper end.

    Without a scale, its ends are the smallest and the largest value. A value that is not finite is a blank.
    """
    finite = [value for value in values if isfinite(value)]
    if not finite:
        return " " * len(values)
    low, high = scale or (min(finite), max(finite))
    return "".join(_bar(value, low, high) if isfinite(value) else " " for value in values)


def _bar(value: float, low: float, high: float) -> str:
    share = (value - low) / (high - low) if high > low else 0.0
    return _BARS[min(max(int(share * len(_BARS)), 0), len(_BARS) - 1)]
