"""Time on both ends of the line: the device's clock, and the time answers of the host.

The established device library sets its clock to the host's stamp plus the whole round trip. `DeviceClock`
adds half of it, because the stamp was made about halfway. While the established library waits for a service
response, a time answer ends that wait with an empty result. `AnswerGate` therefore delays time answers, for a
limited time.
"""

from __future__ import annotations

from rostether.rostime import Time

# How often a configured device requests the time (established library: 5 s / 2).
REQUEST_PERIOD_S = 2.5

# Our own devices ask a little more often, so that one lost answer matters less.
OUR_REQUEST_PERIOD_S = 2.2

# Without an answer within this time, a device becomes unconfigured (established library: 5 * 2.2 s).
SYNC_LOST_S = 11.0

# A device sets its clock back only by more than this: longer than any round trip, as in the C++ client.
MAX_HOLD_S = 10.0

# With 2.5 s between requests, a held answer comes at most 7.5 s after the previous one: before `SYNC_LOST_S`.
HOLD_LIMIT_S = 5.0


class DeviceClock:
    """A device's clock: time since boot until the host answers, then the host's time.

    It never goes back by less than MAX_HOLD_S. If the host's clock stops, as in a paused simulation, the
    device's clock stops from the next answer until the host has caught up.
    """

    def __init__(self, boot_s: float) -> None:
        self._offset_ns = -round(boot_s * 1e9)
        self._requested_s: float | None = None
        self._latest_ns = 0

    def requested(self, now_s: float) -> None:
        """Record a time request; an earlier one counts as lost."""
        self._requested_s = now_s

    def answered(self, time: Time, now_s: float) -> float:
        """Set the clock to the host's stamp; return the round trip in seconds, 0 without a request."""
        round_trip_s = 0.0 if self._requested_s is None else max(now_s - self._requested_s, 0.0)
        self._requested_s = None
        self._offset_ns = time.to_ns() + round(round_trip_s / 2 * 1e9) - round(now_s * 1e9)
        return round_trip_s

    def time(self, now_s: float) -> Time:
        """Return the time at `now_s`."""
        time_ns = round(now_s * 1e9) + self._offset_ns
        if not 0 < self._latest_ns - time_ns < MAX_HOLD_S * 1e9:
            self._latest_ns = time_ns
        return Time.from_ns(self._latest_ns)


class AnswerGate:
    """Closed during a service call of the device, until a frame has waited too long."""

    def __init__(self) -> None:
        self._calls = 0
        self._held_since_s: float | None = None

    def call_started(self) -> None:
        """Count a call that has started."""
        self._calls += 1

    def call_finished(self) -> None:
        """Count a call that has ended."""
        self._calls = max(self._calls - 1, 0)

    def forget_calls(self) -> None:
        """Forget calls: a device that was reset waits for none."""
        self._calls = 0

    def is_closed(self, now_s: float) -> bool:
        """Return whether a time answer must wait."""
        if self._calls == 0:
            return False
        return self._held_since_s is None or now_s < self._held_since_s + HOLD_LIMIT_S

    def hold(self, now_s: float) -> None:
        """Record that a frame waits; the wait of the first one counts."""
        if self._held_since_s is None:
            self._held_since_s = now_s

    def release(self) -> None:
        """Record that no frame waits."""
        self._held_since_s = None

    def get_timer(self) -> float | None:
        """Return the latest time to release the waiting frames, None if no frame waits."""
        return None if self._held_since_s is None else self._held_since_s + HOLD_LIMIT_S
