"""The counters of a link."""

from __future__ import annotations

from msgspec import Struct, field

from rostether.rosserial.events import DAMAGE, DiscardReason


class LinkStatistics(Struct):
    """Counters of one link since its start."""

    bytes_received: int = 0
    frames_received: int = 0
    discarded: dict[DiscardReason, int] = field(default_factory=dict)
    discarded_bytes: int = 0
    unannounced_messages: int = 0
    topic_requests: int = 0
    resets: int = 0
    time_requests: int = 0
    shortest_round_trip_s: float | None = None

    @property
    def damaged_frames(self) -> int:
        """The number of apparent frames that failed a check."""
        return sum(self.discarded.get(reason, 0) for reason in DAMAGE)

    def count_discarded(self, reason: DiscardReason, size: int) -> None:
        """Count one stretch of discarded bytes."""
        self.discarded[reason] = self.discarded.get(reason, 0) + 1
        self.discarded_bytes += size

    def note_round_trip(self, round_trip_s: float) -> None:
        """Note the response time of a device for a request that needs no work."""
        shortest = self.shortest_round_trip_s
        self.shortest_round_trip_s = round_trip_s if shortest is None else min(shortest, round_trip_s)
