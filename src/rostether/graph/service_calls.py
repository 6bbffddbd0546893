"""The time limit of service calls, on all graphs."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from rostether.errors import ServiceTimeoutError


@asynccontextmanager
async def answer_within(service: str, timeout_s: float | None) -> AsyncIterator[None]:
    """Limit the time for a service's answer, which the block awaits. Raises ServiceTimeoutError."""
    try:
        async with asyncio.timeout(timeout_s):
            yield
    except TimeoutError:
        raise ServiceTimeoutError(
            f"service {service} did not answer within {timeout_s:g} s; check that its node does not hang"
        ) from None
