"""The delay before the next attempt: longer each time, and random, so that peers do not retry together."""

from __future__ import annotations

import random


class Backoff:
    """Delays of `first_s`, doubled up to `limit_s`, each shortened by a random share of at most `jitter`."""

    def __init__(self, *, first_s: float = 0.1, limit_s: float = 5.0, jitter: float = 0.25) -> None:
        self._first_s = first_s
        self._limit_s = limit_s
        self._jitter = jitter
        self._next_s = first_s

    def next_delay_s(self) -> float:
        """Return the delay before the next attempt, and lengthen the one after it."""
        delay_s = self._next_s
        self._next_s = min(delay_s * 2, self._limit_s)
        return delay_s * (1.0 - self._jitter * random.random())  # noqa: S311 - it need not be secret

    def reset(self) -> None:
        """Start again with the shortest delay, after an attempt that succeeded."""
        self._next_s = self._first_s
