"""Rates, delays and bandwidth over a sliding window, with the output of rostopic."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

from msgspec import Struct
from msgspec.structs import asdict

# The messages in a window without --window: about 15 minutes at 50 Hz, 400 kB.
DEFAULT_WINDOW = 50_000

# As in `rostopic bw`: short enough to follow a change within seconds.
DEFAULT_BANDWIDTH_WINDOW = 100


class Spread(Struct, frozen=True):
    """Statistics of `window` messages: mean, extremes and standard deviation, in seconds."""

    mean_s: float
    min_s: float
    max_s: float
    std_dev_s: float
    window: int

    @property
    def rate_hz(self) -> float:
        """The rate of a mean interval; 0 if all messages arrived at once."""
        return 1.0 / self.mean_s if self.mean_s > 0 else 0.0


def _spread(values: Sequence[float], window: int) -> Spread:
    count = len(values)
    mean = sum(values) / count
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / count)
    return Spread(mean, min(values), max(values), deviation, window)


class IntervalWindow:
    """The intervals between a topic's messages; `window` is a number of messages, None for the default."""

    def __init__(self, window: int | None = None) -> None:
        self._intervals: deque[float] = deque(maxlen=(window or DEFAULT_WINDOW) - 1)
        self._last_s: float | None = None
        self._reported_s: float | None = None

    @property
    def intervals_s(self) -> list[float]:
        """The intervals, the oldest first."""
        return list(self._intervals)

    def add(self, now_s: float) -> None:
        """Count a message; start again if the clock went back, as a simulated one does at a restart."""
        if self._last_s is None or now_s < self._last_s:
            self._intervals.clear()
        else:
            self._intervals.append(now_s - self._last_s)
        self._last_s = now_s

    def report(self) -> Spread | None:
        """Return the spread; None before the second message, or if none has arrived since the last report."""
        if not self._intervals or self._last_s == self._reported_s:
            return None
        self._reported_s = self._last_s
        return _spread(self._intervals, len(self._intervals) + 1)


class DelayWindow:
    """The ages of a topic's messages on arrival; `window` is a number of messages, None for the default."""

    def __init__(self, window: int | None = None) -> None:
        self._delays: deque[float] = deque(maxlen=window or DEFAULT_WINDOW)
        self._is_changed = False

    def add(self, now_s: float, stamp_s: float) -> None:
        """Count a message that arrived at `now_s`; `stamp_s` is the time in its header."""
        self._delays.append(now_s - stamp_s)
        self._is_changed = True

    def report(self) -> Spread | None:
        """Return the spread, or None if no message has arrived since the last report."""
        if not self._is_changed:
            return None
        self._is_changed = False
        return _spread(self._delays, len(self._delays))


class Bandwidth(Struct, frozen=True):
    """Bytes per second, and the sizes of the messages in the window; `window` is their number."""

    bytes_per_s: float
    mean_bytes: float
    min_bytes: int
    max_bytes: int
    window: int


class SizeWindow:
    """The sizes and arrival times of a topic's messages."""

    def __init__(self, window: int = DEFAULT_BANDWIDTH_WINDOW) -> None:
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=window)

    @property
    def arrivals(self) -> list[tuple[float, int]]:
        """The arrival time in seconds and the size in bytes of each message, the oldest first."""
        return list(self._arrivals)

    def add(self, now_s: float, size_bytes: int) -> None:
        """Count a message."""
        self._arrivals.append((now_s, size_bytes))

    def report(self, now_s: float) -> Bandwidth | None:
        """Return the bandwidth up to now; None before the second message."""
        if len(self._arrivals) < 2:
            return None
        sizes = [size for _, size in self._arrivals]
        total = sum(sizes)
        span_s = max(now_s - self._arrivals[0][0], 1e-9)
        return Bandwidth(total / span_s, total / len(sizes), min(sizes), max(sizes), len(sizes))


def format_rate(spread: Spread) -> str:
    """Return the two lines of `rostopic hz`."""
    return f"average rate: {spread.rate_hz:.3f}\n{_format_spread(spread)}"


def format_delay(spread: Spread) -> str:
    """Return the two lines of `rostopic delay`."""
    return f"average delay: {spread.mean_s:.3f}\n{_format_spread(spread)}"


def format_bandwidth(bandwidth: Bandwidth) -> str:
    """Return the two lines of `rostopic bw`, all in the unit that suits the average."""
    divisor, unit, _ = _unit(bandwidth)
    average, mean, low, high = (f"{each / divisor:.2f}{unit}" for each in _amounts(bandwidth))
    return f"average: {average}/s\n\tmean: {mean} min: {low} max: {high} window: {bandwidth.window}"


def format_ros2_bandwidth(bandwidth: Bandwidth) -> str:
    """Return the two lines of `ros2 topic bw`, all in the unit that suits the average."""
    divisor, unit, digits = _unit(bandwidth)
    average, mean, low, high = (f"{each / divisor:.{digits}f} {unit}" for each in _amounts(bandwidth))
    return f"{average}/s from {bandwidth.window} messages\n\tMessage size mean: {mean} min: {low} max: {high}"


def _unit(bandwidth: Bandwidth) -> tuple[float, str, int]:
    """Return the bytes in the unit, its name, and the decimals that `ros2 topic bw` prints."""
    if bandwidth.bytes_per_s < 1e3:
        return 1, "B", 0
    return (1e3, "KB", 2) if bandwidth.bytes_per_s < 1e6 else (1e6, "MB", 2)


def _amounts(bandwidth: Bandwidth) -> tuple[float, ...]:
    return bandwidth.bytes_per_s, bandwidth.mean_bytes, bandwidth.min_bytes, bandwidth.max_bytes


def format_rate_table(spreads: dict[str, Spread]) -> str:
    """Return the table that `rostopic hz` prints for several topics."""
    rows = [
        (
            topic,
            *(f"{value:.4}" for value in (spread.rate_hz, spread.min_s, spread.max_s, spread.std_dev_s)),
            str(spread.window),
        )
        for topic, spread in spreads.items()
    ]
    header = ("topic", "rate", "min_delta", "max_delta", "std_dev", "window")
    widths = [max(len(cell) for cell in column) for column in zip(header, *rows, strict=True)]
    lines = ["   ".join(cell.center(width) for cell, width in zip(header, widths, strict=True))]
    lines.append("=" * len(lines[0]))
    lines += ["   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(lines) + "\n"


def rate_record(topic: str, spread: Spread) -> dict[str, object]:
    """Return a rate as a JSON object with units in its keys."""
    record = asdict(spread)
    return {"topic": topic, "rate_hz": spread.rate_hz, "mean_interval_s": record.pop("mean_s"), **record}


def _format_spread(spread: Spread) -> str:
    return (
        f"\tmin: {spread.min_s:.3f}s max: {spread.max_s:.3f}s "
        f"std dev: {spread.std_dev_s:.5f}s window: {spread.window}"
    )
