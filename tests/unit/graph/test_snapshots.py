from __future__ import annotations

import asyncio

import pytest

from rostether.errors import GraphError
from rostether.graph.ports import Snapshot
from rostether.graph.snapshots import SharedSnapshots, poll_snapshots


class SlowGraph:
    """A graph whose snapshots are numbered, and wait until the test permits them."""

    def __init__(self) -> None:
        self.count = 0
        self.may_answer = asyncio.Event()
        self.is_gone = False

    async def snapshot(self) -> Snapshot:
        self.count += 1
        number = self.count
        await self.may_answer.wait()
        if self.is_gone:
            raise GraphError("gone")
        return Snapshot(nodes=(f"/n{number}",))


async def test_callers_share_the_snapshot_that_begins_after_their_call() -> None:
    graph = SlowGraph()
    shared = SharedSnapshots(graph.snapshot)
    first = asyncio.ensure_future(shared.take())
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert graph.count == 1
    later = [asyncio.ensure_future(shared.take()) for _ in range(50)]
    await asyncio.sleep(0)
    later.pop().cancel()
    graph.may_answer.set()
    assert (await first).nodes == ("/n1",)
    assert {each.nodes for each in await asyncio.gather(*later)} == {("/n2",)}
    assert (await shared.take()).nodes == ("/n3",)


async def test_all_callers_get_the_error_and_the_next_one_tries_again() -> None:
    graph = SlowGraph()
    graph.may_answer.set()
    graph.is_gone = True
    shared = SharedSnapshots(graph.snapshot)
    found = await asyncio.gather(shared.take(), shared.take(), return_exceptions=True)
    assert [str(each) for each in found] == ["gone", "gone"]
    graph.is_gone = False
    assert (await shared.take()).nodes == ("/n2",)
    graph.is_gone = True
    with pytest.raises(GraphError):
        await shared.take()


async def test_only_changes_are_reported() -> None:
    snapshots = [Snapshot(("/a",)), Snapshot(("/a",)), Snapshot(("/b",))]
    closed = asyncio.Event()

    async def take() -> Snapshot:
        return snapshots.pop(0)

    changes = poll_snapshots(take, closed, 0.001)
    assert [await anext(changes), await anext(changes)] == [Snapshot(("/a",)), Snapshot(("/b",))]
    closed.set()
    assert await anext(changes, None) is None


@pytest.mark.parametrize("turns", range(4))
async def test_a_cancellation_while_the_graph_closes_is_not_ignored(turns: int) -> None:
    polled, closed = asyncio.Event(), asyncio.Event()

    async def take() -> Snapshot:
        return Snapshot()

    async def poll() -> None:
        async for _snapshot in poll_snapshots(take, closed, 60):
            polled.set()

    polling = asyncio.ensure_future(poll())
    await polled.wait()
    closed.set()
    for _ in range(turns):
        await asyncio.sleep(0)
    if polling.cancel():
        with pytest.raises(asyncio.CancelledError):
            await polling
