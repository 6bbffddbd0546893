"""Retries: delays that grow, and waiting for a ROS master that does not answer yet."""

from __future__ import annotations

import asyncio
import random
from collections.abc import Awaitable, Callable
from typing import TypeVar

from rostether.errors import GraphError, MasterUnreachableError

# Most masters answer the first or second attempt: a launch starts them together with its nodes.
FIRST_RETRY_S = 0.2
# As often as rospy; users who start a master expect the nodes within a second.
MAX_RETRY_S = 0.5

ResultT = TypeVar("ResultT")


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


async def wait_for_master(
    attempt: Callable[[], Awaitable[ResultT]],
    report: Callable[[GraphError], object],
    *,
    max_retry_s: float = MAX_RETRY_S,
    errors: type[GraphError] = MasterUnreachableError,
) -> ResultT:
    """Return the result of `attempt`; while it raises `errors`, wait and try again.

    `report` gets the first such error. `max_retry_s` is the longest time between two attempts. Raises the
    other errors of `attempt`.
    """
    backoff = Backoff(first_s=min(FIRST_RETRY_S, max_retry_s), limit_s=max_retry_s)
    is_reported = False
    while True:
        try:
            return await attempt()
        except errors as error:
            if not is_reported:
                is_reported = True
                report(error)
        await asyncio.sleep(backoff.next_delay_s())
