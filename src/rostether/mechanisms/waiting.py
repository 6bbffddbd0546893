"""Waiting for a ROS master that does not answer yet: one line for users, then attempts until it does."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeVar

from rostether.errors import GraphError, MasterUnreachableError
from rostether.mechanisms.backoff import Backoff

# Most masters answer the first or second attempt: a launch starts them together with its nodes.
FIRST_RETRY_S = 0.2
# As often as rospy; users who start a master expect the nodes within a second.
MAX_RETRY_S = 0.5

ResultT = TypeVar("ResultT")


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
