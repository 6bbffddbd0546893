"""Starts background tasks, cancels them, runs work until something else ends, and waits for events."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Coroutine
from typing import Any, TypeVar

Result = TypeVar("Result")


def start_task(tasks: set[asyncio.Task[Any]], work: Coroutine[Any, Any, Result]) -> asyncio.Task[Result]:
    """Start a task that is in `tasks` until it ends: the event loop alone does not keep a task alive."""
    task = asyncio.get_running_loop().create_task(work)
    tasks.add(task)
    task.add_done_callback(tasks.discard)
    return task


async def cancel_all(*tasks: asyncio.Future[Any]) -> None:
    """Cancel tasks and wait for their end. Their errors are ignored."""
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


async def occurs_within(event: asyncio.Event, limit_s: float | None) -> bool:
    """Wait until an event is set; return False if that takes longer than `limit_s` (None: no limit)."""
    # Not asyncio.wait_for: in Python 3.11, it ignores a cancellation that arrives together with the event.
    try:
        async with asyncio.timeout(limit_s):
            return await event.wait()
    except TimeoutError:
        return False


async def run_until(work: Awaitable[object], end: Awaitable[object]) -> None:
    """Run `work` until it is done, or cancel it when `end` is; then both have ended.

    Raises the error of `work`, including one that it raises when canceled.
    """
    working = asyncio.ensure_future(work)
    ending = asyncio.ensure_future(end)
    try:
        await asyncio.wait([working, ending], return_when=asyncio.FIRST_COMPLETED)
    finally:
        working.cancel()
        ending.cancel()
        await asyncio.wait([working, ending])
        if not working.cancelled():
            working.result()
