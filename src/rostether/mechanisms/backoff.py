"""The delay before the next attempt: longer each time up to a limit, and different for each user."""

from __future__ import annotations

import random


class Backoff:
    """Yields delays: `first_s`, growing by `factor` up to `limit_s`, each shortened by up to `jitter`."""

    def __init__(
        self,
        *,
        first_s: float = 0.1,
        limit_s: float = 5.0,
        factor: float = 2.0,
        jitter: float = 0.25,
        rng: random.Random | None = None,
    ) -> None:
        if not (0 < first_s <= limit_s and factor >= 1.0 and 0.0 <= jitter < 1.0):
            raise ValueError("a back-off needs 0 < first_s <= limit_s, factor >= 1 and 0 <= jitter < 1")
        self._first_s = first_s
        self._limit_s = limit_s
        self._factor = factor
        self._jitter = jitter
        self._random = rng.random if rng is not None else random.random
        self._next_s = first_s

    def next_delay_s(self) -> float:
        """Return the delay before the next attempt, and lengthen the one after it."""
        delay_s = self._next_s
        self._next_s = min(delay_s * self._factor, self._limit_s)
        return delay_s * (1.0 - self._jitter * self._random())

    def reset(self) -> None:
        """Start again with the shortest delay, after an attempt that succeeded."""
        self._next_s = self._first_s
