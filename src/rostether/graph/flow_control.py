"""Back-pressure of one publication: when a subscriber's backlog pauses the publisher, and for how long.

A subscriber's backlog is the published data that has not been sent yet. While it is above the subscriber's
mark, the publisher should pause (`publish_raw` returns False).

    event                                       mark
    at first, and whenever the backlog is low   high water
    a pause ends, and data was sent             unchanged: the publisher continues at the subscriber's rate
    a pause ends, and almost no data was sent   one step up, a small one while its node reads the same topic
                                                from others; at the limit of the queue, the publisher no
                                                longer waits, and the oldest messages are dropped
    data is sent after that                     one step below the limit

So a subscriber that reads, even slowly, loses nothing; one that hangs pauses the publisher STEPS times.
A node that receives many floods may read one connection for seconds before it reads the next.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from msgspec import Struct

from rostether.mechanisms.tasks import occurs_within

# The data that waits for one subscriber before its oldest messages are dropped. This is 0.3 s of the fastest
# flood (13 MB/s), three times the longest pause of a board, and 20 s of the fastest serial line.
DEFAULT_QUEUE_BYTES = 4 << 20

# 20 ms of that flood: a subscriber stays busy until its publisher continues, without a noticeable delay.
HIGH_WATER_BYTES = 256 << 10

# The flow resumes when the backlog is below the high-water mark divided by this, so that it does not flap.
LOW_WATER_DIVISOR = 4

# Three seconds of the bridge's pauses: a busy system may stop a healthy subscriber for this time.
STEPS = 32

# Half a minute of pauses: a node that reads other connections for longer does not return to this one.
SMALL_STEPS = 300

# A subscriber that reads less than this in a pause hangs. In the bridge's pauses this is 160 kB/s, so dozens
# of floods may share one subscriber.
MIN_READ_BYTES = 16 << 10


class PublicationFlow:
    """The flows of one publication's subscribers together."""

    def __init__(self) -> None:
        self._congested: set[SubscriberFlow] = set()
        self._open = asyncio.Event()
        self._open.set()

    @property
    def is_open(self) -> bool:
        """Whether the publisher need not pause."""
        return not self._congested

    async def drained(self, timeout_s: float) -> None:
        """Wait until no subscriber is congested, at most `timeout_s`; after this time, the pause ends."""
        if not self._congested:
            return
        before = list(self._congested)
        if not await occurs_within(self._open, timeout_s):
            for flow in before:
                flow.end_pause()

    def note_congestion(self, flow: SubscriberFlow, *, is_congested: bool) -> None:
        """Record that a subscriber's backlog has risen above its mark, or is low again."""
        if is_congested:
            self._congested.add(flow)
            self._open.clear()
        else:
            self._congested.discard(flow)
            if not self._congested:
                self._open.set()


class Reader(Struct, weakref=True):
    """A node that reads one topic, perhaps from several publishers: counts its reads."""

    read_count: int = 0


class SubscriberFlow:
    """The mark of one subscriber; `measure` returns its backlog in bytes, `limit_bytes` limits its queue."""

    def __init__(
        self,
        publication: PublicationFlow,
        measure: Callable[[], int],
        limit_bytes: int = DEFAULT_QUEUE_BYTES,
        reader: Reader | None = None,
    ) -> None:
        self.reader = reader or Reader()
        self._publication = publication
        self._measure = measure
        self._limit_bytes = limit_bytes
        self._high_water_bytes = min(HIGH_WATER_BYTES, limit_bytes // 2)
        rise_bytes = limit_bytes - self._high_water_bytes
        self._step_bytes = max(rise_bytes // STEPS, 1)
        self._small_step_bytes = max(rise_bytes // SMALL_STEPS, 1)
        self._mark_bytes = self._high_water_bytes
        self._is_congested = False
        self._before_pause_bytes = 0
        self._before_pause_reads = 0

    @property
    def hangs(self) -> bool:
        """Whether the subscriber read almost nothing in all pauses for it."""
        return self._mark_bytes >= self._limit_bytes

    def update(self) -> None:
        """Check the backlog; called after each change."""
        backlog_bytes = self._measure()
        if backlog_bytes <= self._high_water_bytes // LOW_WATER_DIVISOR:
            self.end()
        elif backlog_bytes > self._mark_bytes and not self._is_congested and not self.hangs:
            self._is_congested = True
            self._begin_pause(backlog_bytes)
            self._publication.note_congestion(self, is_congested=True)

    def note_sent(self) -> None:
        """Record that a part of the backlog was sent."""
        self.reader.read_count += 1
        if self.hangs:
            self._mark_bytes = self._limit_bytes - self._step_bytes
        self.update()

    def end_pause(self) -> None:
        """End a pause; the next one begins if the backlog is still above the mark."""
        if not self._is_congested:
            return
        backlog_bytes = self._measure()
        if self._before_pause_bytes - backlog_bytes < MIN_READ_BYTES:
            reads_others = self.reader.read_count != self._before_pause_reads
            self._mark_bytes += self._small_step_bytes if reads_others else self._step_bytes
        self._begin_pause(backlog_bytes)
        if backlog_bytes <= self._mark_bytes or self.hangs:
            self._reopen()

    def end(self) -> None:
        """Forget the flow: its backlog is low, or its subscriber has disconnected."""
        self._mark_bytes = self._high_water_bytes
        self._reopen()

    def _begin_pause(self, backlog_bytes: int) -> None:
        self._before_pause_bytes = backlog_bytes
        self._before_pause_reads = self.reader.read_count

    def _reopen(self) -> None:
        if self._is_congested:
            self._is_congested = False
            self._publication.note_congestion(self, is_congested=False)
