"""The host's time: the host's last answer plus the board's milliseconds since then."""

from ros.ticks import ticks_diff
from ros.times import Time

# Longer than any round trip, so that late answers do not set the clock back. The clock must not stop for much
# longer.
_MAX_HOLD_S = 10


class Clock:
    """A clock that does not go back.

    After an answer below the last returned time, it stops until the host's time is later. It follows the host
    back only if the host's clock was set back by more than 10 s.
    """

    def __init__(self, now_ms):
        self._sec = self._nsec = 0
        self._returned_sec = self._returned_nsec = 0
        self._ms = now_ms

    def advance(self, now_ms):
        """Make a moment of the board's clock the new reference, so that its counter may start at 0 again."""
        elapsed_ms = ticks_diff(now_ms, self._ms)
        self._ms = now_ms
        nsec = self._nsec + elapsed_ms % 1000 * 1000000
        self._sec += elapsed_ms // 1000 + nsec // 1000000000
        self._nsec = nsec % 1000000000

    def at(self, now_ms):
        """Return the time at a moment of the board's clock."""
        self.advance(now_ms)
        behind_s = self._returned_sec - self._sec
        if behind_s < 0 or behind_s >= _MAX_HOLD_S or (behind_s == 0 and self._nsec >= self._returned_nsec):
            self._returned_sec = self._sec
            self._returned_nsec = self._nsec
        return Time(self._returned_sec, self._returned_nsec)

    def follow(self, sec, nsec, now_ms, age_ms):
        """Set the clock: `sec` and `nsec` were the host's time `age_ms` before `now_ms`."""
        self._sec = sec
        self._nsec = nsec + age_ms * 1000000
        self._ms = now_ms
        self.advance(now_ms)

    def set(self, moment, now_ms):
        """Set the time; it may be an earlier one."""
        self._returned_sec = 0
        self.follow(moment.sec, moment.nsec, now_ms, 0)
