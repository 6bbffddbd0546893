"""How late this process runs on a busy machine, which is added to every measurement."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

_TICK_S = 0.01


class Lateness:
    """Sums the delays of the test's own waits."""

    def __init__(self) -> None:
        self.total_s = 0.0

    async def watch(self) -> None:
        """Measure until canceled."""
        clock = asyncio.get_running_loop().time
        while True:
            began_s = clock()
            await asyncio.sleep(_TICK_S)
            self.total_s += max(0.0, clock() - began_s - _TICK_S)


@contextlib.asynccontextmanager
async def lateness() -> AsyncIterator[Lateness]:
    """Measure until the block ends.

    Work of this process that blocks its loop also counts; if that is possible, measure processor time
    instead.
    """
    measured = Lateness()
    watching = asyncio.create_task(measured.watch())
    try:
        yield measured
    finally:
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)
