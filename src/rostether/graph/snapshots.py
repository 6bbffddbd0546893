"""Snapshots of graphs: shared by callers, merged, and one after each change."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Iterable, Sequence
from contextlib import aclosing, asynccontextmanager

from rostether.errors import GraphError
from rostether.graph.ports import Graph, ServiceEntry, Snapshot, TopicEntry
from rostether.mechanisms.tasks import cancel_all, occurs_within
from rostether.msgdef.interface import ANY_TYPE


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

    @asynccontextmanager
    async def wakeup(self, closed: asyncio.Event) -> AsyncIterator[asyncio.Event]:
        """Yield an event that is set after each change, and when `closed` is set."""
        event = asyncio.Event()
        self._events.add(event)
        waiting = asyncio.ensure_future(closed.wait())
        waiting.add_done_callback(lambda _: event.set())
        try:
            yield event
        finally:
            waiting.cancel()
            self._events.discard(event)

    async def follow(self, take: Callable[[], Snapshot], closed: asyncio.Event) -> AsyncIterator[Snapshot]:
        """Yield a snapshot from `take` now and one after each change, until `closed` is set."""
        latest = None
        async with self.wakeup(closed) as event:
            while not closed.is_set():
                event.clear()
                snapshot = take()
                if snapshot != latest:
                    latest = snapshot
                    yield snapshot
                else:
                    await event.wait()


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
        if await occurs_within(closed, interval_s):
            return


def merge_snapshots(snapshots: Iterable[Snapshot]) -> Snapshot:
    """Return all snapshots as one; a topic has the first known type."""
    nodes: set[str] = set()
    topics: dict[str, TopicEntry] = {}
    services: dict[str, ServiceEntry] = {}
    problems: list[str] = []
    for snapshot in snapshots:
        nodes.update(snapshot.nodes)
        for name, topic in snapshot.topics.items():
            topics[name] = _merge_topics(topics[name], topic) if name in topics else topic
        for name, service in snapshot.services.items():
            services[name] = _merge_services(services[name], service) if name in services else service
        if snapshot.problem:
            problems.append(snapshot.problem)
    return Snapshot(
        tuple(sorted(nodes)),
        dict(sorted(topics.items())),
        dict(sorted(services.items())),
        "; ".join(problems),
    )


async def follow_changes(
    graphs: Callable[[], Sequence[Graph]], joined: ChangeSignal, closed: asyncio.Event
) -> AsyncGenerator[Snapshot]:
    """Yield a merged snapshot now and after each change, as `follow_each` does."""
    reported: Snapshot | None = None
    async with aclosing(follow_each(graphs, joined, closed)) as changes:
        async for snapshots in changes:
            merged = merge_snapshots(snapshots)
            if merged != reported:
                reported = merged
                yield merged


async def follow_each(
    graphs: Callable[[], Sequence[Graph]], joined: ChangeSignal, closed: asyncio.Event
) -> AsyncGenerator[list[Snapshot]]:
    """Yield a snapshot of each graph now and after each change, until all have ended or `closed` is set.

    `joined` reports that another graph has joined.
    """
    latest: dict[Graph, Snapshot] = {}
    tasks: dict[Graph, asyncio.Task[None]] = {}
    reported: list[Snapshot] = []
    async with joined.wakeup(closed) as wakeup:
        try:
            while True:
                for graph in graphs():
                    if graph not in tasks:
                        tasks[graph] = asyncio.ensure_future(_follow(graph, latest, wakeup))
                snapshots = [latest[graph] for graph in graphs() if graph in latest]
                if snapshots and snapshots != reported:
                    reported = snapshots
                    yield snapshots
                    continue
                if closed.is_set() or all(task.done() for task in tasks.values()):
                    return
                await wakeup.wait()
                wakeup.clear()
        finally:
            await cancel_all(*tasks.values())


async def _follow(graph: Graph, latest: dict[Graph, Snapshot], wakeup: asyncio.Event) -> None:
    """Keep the latest snapshot of a graph until it ends."""
    try:
        async for snapshot in graph.changes():
            latest[graph] = snapshot
            wakeup.set()
    except GraphError:
        latest.pop(graph, None)  # A graph that cannot be read has no part in the snapshot.
    finally:
        wakeup.set()


def _merge_topics(one: TopicEntry, other: TopicEntry) -> TopicEntry:
    return TopicEntry(
        one.name,
        other.type if one.type == ANY_TYPE else one.type,
        _merge_names(one.publishers, other.publishers),
        _merge_names(one.subscribers, other.subscribers),
    )


def _merge_services(one: ServiceEntry, other: ServiceEntry) -> ServiceEntry:
    return ServiceEntry(
        one.name,
        _merge_names(one.providers, other.providers),
        other.type if one.type == ANY_TYPE else one.type,
    )


def _merge_names(one: Iterable[str], other: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted({*one, *other}))
