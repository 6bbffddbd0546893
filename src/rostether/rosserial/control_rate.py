"""Limits how often a device may cause work with control frames.

Each costs 20 µs to 1 ms, while a message costs a fraction of a microsecond: without a limit, one device could
block all others. Frames beyond the rate are dropped and counted. They are requested again later:
announcements by the host, the time and parameters by the device.
"""

from __future__ import annotations

from typing import NamedTuple

from rostether.mechanisms.rate_limits import TokenBucket
from rostether.rosserial import topic_id as ids


class Allowance(NamedTuple):
    """A rate per second, and the burst that is allowed after a pause."""

    per_s: float
    burst: int


# A negotiation of the largest device, 256 endpoints, takes some rounds; 115200 baud can transfer 150/s.
ANNOUNCEMENTS = Allowance(512.0, 2048)

# Each opens or closes an endpoint in the graph. The largest device can start immediately, and change in 5 s.
CHANGES = Allowance(50.0, 256)

# Log lines: as many short ones as 115200 baud can transfer; users cannot read more.
LOGS = Allowance(500.0, 2000)

# A board asks every 2.5 s, and again for each probe and topic request.
TIME_REQUESTS = Allowance(50.0, 50)

# Parameters: a board requests the next one after it has received the last one.
OTHERS = Allowance(200.0, 500)


class ControlRate:
    """The allowances of one link; the clock is that of `now_s`."""

    def __init__(self) -> None:
        self._buckets = dict.fromkeys(ids.ANNOUNCEMENTS, TokenBucket(*ANNOUNCEMENTS))
        self._buckets |= {ids.LOG: TokenBucket(*LOGS), ids.TIME: TokenBucket(*TIME_REQUESTS)}
        self._others = TokenBucket(*OTHERS)
        self._changes = TokenBucket(*CHANGES)

    def admit(self, topic_id: int, count: int, now_s: float) -> int:
        """Return how many of `count` frames on a reserved id may be processed now."""
        return self._buckets.get(topic_id, self._others).admit(count, now_s)

    def admit_change(self, now_s: float) -> bool:
        """Return whether an announcement may change the graph now."""
        return self._changes.admit(1, now_s) == 1
