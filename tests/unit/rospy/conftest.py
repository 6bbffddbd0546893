"""A ROS master, as a fixture."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest_asyncio

from rostether.ros1.master.server import MasterServer


@pytest_asyncio.fixture
async def master() -> AsyncIterator[str]:
    """Run a ROS master, and return its URI."""
    server = await MasterServer.start(port=0)
    yield server.uri
    await server.close()
