"""Limits how many messages a board may publish per second, with bursts of up to one second's messages."""

from __future__ import annotations

from collections.abc import Callable


class MessageRate:
    """Decides how many messages may pass; after a pause, a board may send `per_s` at once."""

    def __init__(self, per_s: float, clock: Callable[[], float]) -> None:
        self.per_s = per_s
        self._clock = clock
        self._room = per_s
        self._seen_s = clock()

    def admit(self, count: int) -> int:
        """Return how many of `count` messages may pass now, at most all."""
        now_s = self._clock()
        self._room = min(self._room + (now_s - self._seen_s) * self.per_s, max(self.per_s, 1.0))
        self._seen_s = now_s
        admitted = min(count, int(self._room))
        self._room -= admitted
        return admitted
