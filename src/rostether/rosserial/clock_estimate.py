"""Estimates the offset and the rate of a board's clock from the host's time answers and the board's stamps.

A board's time request does not show its clock (the established library leaves the value zero), but its stamps
do. Each time answer sets its clock; until the next one the clock runs freely:

    host time - stamp     an answer                    an answer
         |   .  ' .   .  ' |  '  .   .  '   .  .  '      |
         |.'._.-'--'--'    |_.-'--'--'--'--'            what lies above the lower edge is delay: rejected
         +-----------------+-----------------------------+---> time

A stamp is late by the delay of its message, and never early. So the lower edge shows the clock: its height is
the offset, which is largest at the end, and its slope is the drift. Both ends of an interval are compared,
and the median over many of them rejects the intervals that a busy line distorts. Stamps that are not near the
host's time (zero, or time since boot) show nothing and are omitted.
"""

from __future__ import annotations

from collections import deque

from rostether.mechanisms.median import median

# A stamp that differs more from the host's time is not from the set clock: answers set it every 2.5 s.
MAX_LAG_S = 5.0

# Stamps from before the answer may still arrive for this long.
FRESH_S = 0.1

# A board that gets no answer for this long unconfigures itself, so an interval ends.
MAX_INTERVAL_S = 12.0

# Both ends must be this far apart: with 1 ms of jitter, a shorter interval gives no result.
MIN_SPAN_S = 0.8

# Two and a half minutes: a crystal's drift changes with temperature, more slowly than this.
INTERVALS = 60

# A median of fewer samples does not reject a bad one.
MIN_INTERVALS = 3

# If the least delayed stamp of an end is later than that of the interval by this, the whole end was delayed.
MAX_EXCESS_S = 0.05

_NS = 1e9


class ClockEstimate:
    """The clock of one board; every `now_s` is on one monotonic clock, stamps are in ns since the epoch."""

    def __init__(self) -> None:
        self._answered_s: float | None = None
        self._answered_ns = 0
        self._samples: list[tuple[float, float]] = []
        self._slopes: deque[float] = deque(maxlen=INTERVALS)
        self._ends: deque[tuple[float, float]] = deque(maxlen=MIN_INTERVALS)

    @property
    def drift_ppm(self) -> float | None:
        """How much faster the board's clock runs, in millionths; None while not known."""
        if len(self._slopes) < MIN_INTERVALS:
            return None
        return -median(self._slopes) * 1e6

    def offset_s(self, round_trip_s: float | None = None) -> float | None:
        """Return the lead of the board's clock just before it is set again; None while unknown.

        The transfer time of a stamp without delay counts as half of the line's shortest round trip.
        """
        if not self._ends:
            return None
        slope = median(self._slopes) if self._slopes else 0.0
        return (round_trip_s or 0.0) / 2 - median(lag_s + slope * rest_s for lag_s, rest_s in self._ends)

    def answered(self, host_ns: int, now_s: float) -> None:
        """Note that the board's clock is being set to `host_ns`."""
        self._close()
        self._answered_s, self._answered_ns = now_s, host_ns

    def forget(self) -> None:
        """Note that the board was reset or lost: the current interval is discarded."""
        self._answered_s = None
        self._samples.clear()

    def stamped(self, stamp_ns: int, host_ns: int, now_s: float) -> None:
        """Add a stamp that arrived at `host_ns`, the host's time at `now_s`."""
        if self._answered_s is None:
            return
        elapsed_s = now_s - self._answered_s
        if elapsed_s < FRESH_S:
            return
        # Simulated time has its own speed, so it gives no information about the board's clock.
        if abs((host_ns - self._answered_ns) / _NS - elapsed_s) > 0.005 + 0.001 * elapsed_s:
            self.forget()
            return
        lag_s = (host_ns - stamp_ns) / _NS
        if abs(lag_s) > MAX_LAG_S:
            return
        self._samples.append((elapsed_s, lag_s))
        if elapsed_s > MAX_INTERVAL_S:
            self._close()
            self._answered_s = None

    def _close(self) -> None:
        """Add the two ends of the finished interval."""
        samples, self._samples = self._samples, []
        if not samples:
            return
        first_s, last_s = samples[0][0], samples[-1][0]
        third_s = (last_s - first_s) / 3
        early = min((each for each in samples if each[0] <= first_s + third_s), key=_lag)
        late = min((each for each in samples if each[0] >= last_s - third_s), key=_lag)
        min_lag_s = min(lag_s for _, lag_s in samples)
        self._ends.append((late[1], last_s - late[0]))
        span_s = late[0] - early[0]
        if span_s >= MIN_SPAN_S and max(early[1], late[1]) - min_lag_s <= MAX_EXCESS_S:
            self._slopes.append((late[1] - early[1]) / span_s)


def _lag(sample: tuple[float, float]) -> float:
    return sample[1]
