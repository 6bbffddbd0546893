"""How fast counters grow, updated once a second."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Generic, TypeVar

# A topic at 1 Hz shows a steady figure, and a change within a few seconds.
WINDOW_S = 5.0

Key = TypeVar("Key")


class Rates(Generic[Key]):
    """The growth of counters over the last few updates."""

    def __init__(self) -> None:
        self._looks: deque[tuple[float, dict[Key, int]]] = deque()

    def update(self, counts: Mapping[Key, int], now_s: float) -> dict[Key, float]:
        """Read the counters and return their growth per second; empty at the first call.

        A counter that is lower than before belongs to a new connection and started from zero.
        """
        self._looks.append((now_s, dict(counts)))
        while len(self._looks) > 2 and now_s - self._looks[0][0] > WINDOW_S:
            self._looks.popleft()
        before_s, before = self._looks[0]
        span_s = now_s - before_s
        if span_s <= 0:
            return {}
        return {
            key: (count - before[key] if count >= before.get(key, 0) and key in before else count) / span_s
            for key, count in counts.items()
        }
