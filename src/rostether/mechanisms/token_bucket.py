"""A limit of a rate that allows bursts."""

from __future__ import annotations


class TokenBucket:
    """Admits `per_s` events a second, and up to `burst` at once after a pause."""

    def __init__(self, per_s: float, burst: float, now_s: float = 0.0) -> None:
        self._per_s = per_s
        self._burst = burst
        self._room = burst
        self._counted_s = now_s

    def room(self, now_s: float) -> float:
        """Return how many events may pass now."""
        self._room = min(self._room + (now_s - self._counted_s) * self._per_s, self._burst)
        self._counted_s = now_s
        return self._room

    def admit(self, count: int, now_s: float) -> int:
        """Count events that pass now; return how many of `count` may."""
        admitted = min(count, int(self.room(now_s)))
        self._room -= admitted
        return admitted
