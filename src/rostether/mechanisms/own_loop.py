"""Runs work that blocks between its awaits, such as a search of folders, without blocking the event loop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar

Result = TypeVar("Result")


async def in_own_loop(work: Callable[[], Coroutine[Any, Any, Result]]) -> Result:
    """Await `work()` on an event loop in its own thread; return its result or raise its error.

    When the caller is canceled, so is the work, and the caller waits until it has ended.
    """
    outer = asyncio.get_running_loop()
    started: asyncio.Future[Callable[[], object]] = outer.create_future()

    async def run() -> Result:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        assert task is not None
        outer.call_soon_threadsafe(started.set_result, partial(loop.call_soon_threadsafe, task.cancel))
        return await work()

    thread = asyncio.ensure_future(asyncio.to_thread(asyncio.run, run()))
    try:
        return await asyncio.shield(thread)
    except asyncio.CancelledError:
        cancel = await started
        with suppress(RuntimeError):  # it has just ended by itself
            cancel()
        # The caller already gets its end as a cancellation.
        await asyncio.gather(thread, return_exceptions=True)
        raise
