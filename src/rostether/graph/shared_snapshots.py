"""Snapshots of a graph that several callers need at once."""

from __future__ import annotations

import asyncio

from rostether.graph.ports import Graph, Snapshot


class SharedSnapshots:
    """Takes one snapshot for all who ask while another is being taken.

    A snapshot of a large graph needs thousands of objects, and a flood of requests would need them each.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._running: asyncio.Task[Snapshot] | None = None
        self._next: asyncio.Task[Snapshot] | None = None

    async def take(self) -> Snapshot:
        """Return a snapshot that was requested after this call. Raises GraphError."""
        if self._next is None:
            self._next = asyncio.ensure_future(self._take_after(self._running))
            # Nobody may be left to see its error.
            self._next.add_done_callback(lambda task: task.cancelled() or task.exception())
        return await asyncio.shield(self._next)

    async def _take_after(self, running: asyncio.Task[Snapshot] | None) -> Snapshot:
        if running is not None:
            await asyncio.wait([running])
        self._running, self._next = self._next, None
        return await self._graph.snapshot()
