"""The graph as a real master reports it, while the master is running and while it is not."""

from __future__ import annotations

import asyncio

import pytest

from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.graph_view import watch_changes
from rostether.ros1.node.master_client import MasterClient

WAIT_S = 60.0


async def test_a_master_that_is_away_is_the_problem_until_it_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros1.node.graph_view.POLL_INTERVAL_S", 0.01)
    server = await MasterServer.start(port=0)
    master, closed = MasterClient(server.uri, "/node"), asyncio.Event()
    changes = watch_changes(master, closed)
    async with asyncio.timeout(WAIT_S):
        first = await anext(changes)
        assert first.problem == ""
        await server.close()
        away = await anext(changes)
        assert "cannot be reached" in away.problem
        assert (away.nodes, away.topics) == (first.nodes, first.topics)
        server = await MasterServer.start(port=int(server.uri.rstrip("/").rpartition(":")[2]))
        assert (await anext(changes)).problem == ""
    closed.set()
    await master.close()
    await server.close()
