"""Two graphs in memory, as a fixture."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from rostether.relay import relay as relay_module
from unit.relay.relay_world import World


@pytest_asyncio.fixture
async def world(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[World]:
    # Graphs in memory show changes immediately.
    monkeypatch.setattr(relay_module, "DISCOVERY_S", 0.01)
    monkeypatch.setattr(relay_module, "CHECK_S", 0.05)
    world = World()
    await world.join()
    yield world
    for network in world.networks:
        for graph in list(network.nodes.values()):
            await graph.close()
