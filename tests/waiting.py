"""Waiting for conditions: tests never wait for a fixed time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

# A busy machine may be many times slower than a quiet one.
TIMEOUT_S = 60.0


async def until(condition: Callable[[], object], what: str = "the condition") -> None:
    """Wait until a condition holds; at the time limit, fail with `what`."""
    deadline_s = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline_s, f"gave up waiting for {what}"
        await asyncio.sleep(0.001)
