"""Snapshots of a graph that several callers need at once, and a snapshot after each change of a graph."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress

from rostether.graph.ports import Snapshot


class SharedSnapshots:
    """Takes one snapshot for all callers that wait while another is being taken.

    A snapshot of a large graph has thousands of objects: one for each request of a flood would keep the
    master and the garbage collector busy.
    """

    def __init__(self, take: Callable[[], Awaitable[Snapshot]]) -> None:
        self._take = take
        self._running: asyncio.Task[Snapshot] | None = None
        self._next: asyncio.Task[Snapshot] | None = None

    async def take(self) -> Snapshot:
        """Return a snapshot that was requested after this call. Raises the errors of the request."""
        if self._next is None:
            self._next = asyncio.ensure_future(self._take_after(self._running))
            # All its callers may have been canceled.
            self._next.add_done_callback(lambda task: task.cancelled() or task.exception())
        return await asyncio.shield(self._next)

    async def _take_after(self, running: asyncio.Task[Snapshot] | None) -> Snapshot:
        if running is not None:
            await asyncio.wait([running])
        self._running, self._next = self._next, None
        return await self._take()


class ChangeSignal:
    """Wakes the followers of a graph that reports its changes."""

    def __init__(self) -> None:
        self._events: set[asyncio.Event] = set()

    def notify(self) -> None:
        """Wake all followers: the graph has changed."""
        for event in self._events:
            event.set()

    async def follow(self, take: Callable[[], Snapshot], closed: asyncio.Event) -> AsyncIterator[Snapshot]:
        """Yield a snapshot from `take` now and one after each change, until `closed` is set."""
        event = asyncio.Event()
        self._events.add(event)
        waiting = asyncio.ensure_future(closed.wait())
        waiting.add_done_callback(lambda _: event.set())
        try:
            latest = None
            while not closed.is_set():
                event.clear()
                snapshot = take()
                if snapshot != latest:
                    latest = snapshot
                    yield snapshot
                else:
                    await event.wait()
        finally:
            waiting.cancel()
            self._events.discard(event)


async def poll_snapshots(
    take: Callable[[], Awaitable[Snapshot]], closed: asyncio.Event, interval_s: float
) -> AsyncIterator[Snapshot]:
    """Yield a snapshot from `take` now and one after each change, until `closed` is set."""
    latest: Snapshot | None = None
    while True:
        snapshot = await take()
        if snapshot != latest:
            latest = snapshot
            yield latest
        # Not asyncio.wait_for: in Python 3.11, it ignores a cancellation that arrives together with `closed`.
        with suppress(TimeoutError):
            async with asyncio.timeout(interval_s):
                await closed.wait()
            return
