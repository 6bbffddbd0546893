"""How late a board's time requests are, which shows how slow its loop() is.

A configured board requests the time when 2.5 s have passed (with our library 2.2 s), at its next
nh.spinOnce(). A request that answers a topic request gives no information, unless the periodic one was
already overdue.
"""

from __future__ import annotations

from collections import deque

from rostether.bridge.findings.finding import Code, Finding, warning
from rostether.mechanisms.median import median
from rostether.rosserial.time_sync import OUR_REQUEST_PERIOD_S, REQUEST_PERIOD_S

# For a board that subscribes to topics or serves calls: at 57600 baud, its buffer of 64 bytes fills in 11 ms.
SLOW_LISTENER_S = 0.1

# A board that only publishes, or is on a network, loses nothing; the library's own first example sleeps a
# second in loop(). A network delays requests by a retransmission.
SLOW_TALKER_S = 0.6

# A time request that may answer a topic request is counted only if it is late by more than this.
OVERDUE_S = 0.4

# The jitter of an interval between two requests.
TOLERANCE_S = 0.1

# A board that usually requests the time sooner than this does not wait 2.5 s.
MAX_OUR_PERIOD_S = 2.4

# A board that is later than 11 s was disconnected, not slow.
MAX_LATE_S = 9.0

# The latest 40 s, so that a corrected loop() is not reported for long.
MAX_INTERVALS = 16
# One late request may have another cause.
MIN_COUNT = 2

# Between two pauses, a simulator falls behind by up to 250 ms: the median of four intervals is below 100 ms.
MIN_COUNT_SIMULATED = 4

# A network that loses every tenth datagram loses four of eight requests once in 200 times.
MIN_COUNT_DATAGRAMS = 8


class LoopSpeed:
    """The time requests of one connection; `may_lose`: each request may be lost or delayed."""

    def __init__(self, *, may_lose: bool = False) -> None:
        # Whether the board is known to run rostether's library.
        self.has_own_library = False
        self._last_s: float | None = None
        self._asked = 0
        self._min_count = MIN_COUNT_DATAGRAMS if may_lose else MIN_COUNT
        self._intervals_s: deque[float] = deque(maxlen=MAX_INTERVALS)

    @property
    def late_s(self) -> float | None:
        """The usual delay of the requests; None while unknown."""
        if len(self._intervals_s) < self._min_count:
            return None
        return max(0.0, median(self._intervals_s) - self._period_s)

    @property
    def is_suspect(self) -> bool:
        """Whether one request was late, and no second one has confirmed it."""
        return len(self._intervals_s) == 1 and self._intervals_s[0] - self._period_s >= SLOW_LISTENER_S

    def request(self, now_s: float, asked: int) -> None:
        """Handle a time request; `asked` counts our topic requests, which provoke one each."""
        last_s, self._last_s = self._last_s, now_s
        was_provoked = asked != self._asked
        self._asked = asked
        if last_s is None:
            return
        interval_s = now_s - last_s
        min_s = REQUEST_PERIOD_S + OVERDUE_S if was_provoked else OUR_REQUEST_PERIOD_S - TOLERANCE_S
        if min_s <= interval_s <= REQUEST_PERIOD_S + MAX_LATE_S:
            self._intervals_s.append(interval_s)

    def forget(self) -> None:
        """Ignore the present interval: the board was reset, or a request may have been lost."""
        self._last_s = None

    def note_pause(self) -> None:
        """Record that a simulated board paused: its requests were late because of the simulator."""
        self._last_s = None
        self._min_count = MIN_COUNT_SIMULATED
        self._intervals_s.clear()

    def find(self, *, is_listener: bool) -> Finding | None:
        """Return the finding, if any; `is_listener`: data for the board may overflow its serial buffer."""
        late_s = self.late_s
        if late_s is None or late_s < (SLOW_LISTENER_S if is_listener else SLOW_TALKER_S):
            return None
        return warning(
            Code.SLOW_LOOP,
            f"loop() is too slow: the board's time request is late by {late_s * 1000:.0f} ms "
            f"(at worst {(max(self._intervals_s) - self._period_s) * 1000:.0f} ms)",
            "call nh.spinOnce() every few ms: replace delay() with a comparison of millis(), and split long "
            "work into short steps",
        )

    @property
    def _period_s(self) -> float:
        has_own_library = self.has_own_library or (
            len(self._intervals_s) >= MIN_COUNT and median(self._intervals_s) < MAX_OUR_PERIOD_S
        )
        return OUR_REQUEST_PERIOD_S if has_own_library else REQUEST_PERIOD_S
