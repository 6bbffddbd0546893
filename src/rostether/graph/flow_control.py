"""Back-pressure of one publication: whose backlog slows the publisher down, and for how long.

Each subscriber's flow is in one of three states; its backlog is what was published and has not left yet.

    state      event                            next
    FLOWING    backlog above high water         CONGESTED   (publish_raw now returns False)
    CONGESTED  backlog at or below low water    FLOWING
    CONGESTED  `drained` timed out              SLOW        (pauses nobody, loses its oldest messages)
    SLOW       backlog at or below low water    FLOWING
    SLOW       took a high-water mark's worth   CONGESTED
               within the time of a pause

The last line is for a subscriber that keeps up but was kept from running for a moment: without it, a flood
would not be slowed down again until that subscriber had caught up with a flood.
"""

from __future__ import annotations

import asyncio
from enum import Enum

DEFAULT_QUEUE_BYTES = 4 << 20
"""What waits for one subscriber before its oldest messages go: 0.3 s of the fastest flood we carry
(13 MB/s), three times the longest pause of a board, and 20 s of the fastest serial line."""

HIGH_WATER_BYTES = 256 << 10
"""20 ms of that flood: enough to keep a subscriber busy while its publisher is told, too little to feel."""

LOW_WATER_SHARE = 4
"""Flow goes on when this fraction of the high-water mark is left, so that it does not flap."""


class _State(Enum):
    FLOWING = "flowing"
    CONGESTED = "congested"
    SLOW = "slow"


class PublicationFlow:
    """The flows of one publication's subscribers together."""

    def __init__(self) -> None:
        self._congested: set[SubscriberFlow] = set()
        self._open = asyncio.Event()
        self._open.set()

    @property
    def is_open(self) -> bool:
        """Whether nobody who keeps up otherwise is behind."""
        return not self._congested

    async def drained(self, timeout_s: float) -> None:
        """Wait until nobody is congested; who was before and still is after the time counts as slow."""
        if not self._congested:
            return
        before = list(self._congested)
        try:
            async with asyncio.timeout(timeout_s):
                await self._open.wait()
        except TimeoutError:
            for flow in before:
                flow.give_up(timeout_s)

    def _note(self, flow: SubscriberFlow, *, is_congested: bool) -> None:
        if is_congested:
            self._congested.add(flow)
            self._open.clear()
        else:
            self._congested.discard(flow)
            if not self._congested:
                self._open.set()


class SubscriberFlow:
    """The state of one subscriber."""

    def __init__(self, publication: PublicationFlow, high_water_bytes: int = HIGH_WATER_BYTES) -> None:
        self._publication = publication
        self._high_water_bytes = high_water_bytes
        self._low_water_bytes = high_water_bytes // LOW_WATER_SHARE
        self._state = _State.FLOWING
        # Of a slow one: what it takes, and since when; a new count begins after each pause's time.
        self._pause_s = 0.0
        self._counted_bytes = 0
        self._counted_since_s = 0.0

    @property
    def is_slow(self) -> bool:
        """Whether it has been given up on until its backlog is gone."""
        return self._state is _State.SLOW

    def note_backlog(self, backlog_bytes: int) -> None:
        """Take the backlog after each change of it."""
        if backlog_bytes > self._high_water_bytes:
            if self._state is _State.FLOWING:
                self._state = _State.CONGESTED
                self._publication._note(self, is_congested=True)
        elif self._state is not _State.FLOWING and backlog_bytes <= self._low_water_bytes:
            self.end()

    def note_taken(self, taken_bytes: int, now_s: float) -> None:
        """Take how many bytes left the backlog towards the subscriber; tell it before the backlog."""
        if self._state is _State.SLOW:
            if now_s - self._counted_since_s > self._pause_s:
                self._counted_since_s = now_s
                self._counted_bytes = 0
            self._counted_bytes += taken_bytes
            if self._counted_bytes >= self._high_water_bytes:
                self._state = _State.CONGESTED
                self._publication._note(self, is_congested=True)

    def give_up(self, pause_s: float) -> None:
        """Count it as slow if it is still congested after a pause of that length."""
        if self._state is _State.CONGESTED:
            self._state = _State.SLOW
            self._pause_s = pause_s
            self._counted_since_s = float("-inf")
            self._publication._note(self, is_congested=False)

    def end(self) -> None:
        """Forget it: it flows again, or its subscriber is gone."""
        self._state = _State.FLOWING
        self._publication._note(self, is_congested=False)
