"""Fixtures of the interoperability tests."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from interop.ros1_peers import Ros1Peers, debian_roscore


@pytest_asyncio.fixture
async def roscore(tmp_path: Path) -> AsyncIterator[Ros1Peers]:
    """Debian's roscore and Debian's tools."""
    async with debian_roscore(tmp_path) as peers:
        yield peers


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs Debian's ROS 1."""
    item.add_marker("ros1")
    item.add_marker(pytest.mark.timeout(300))
