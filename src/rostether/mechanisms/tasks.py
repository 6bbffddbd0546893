"""Starts tasks in the background, cancels tasks, and waits for events."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
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
    try:
        async with asyncio.timeout(limit_s):
            return await event.wait()
    except TimeoutError:
        return False
