"""Fixtures of the tests with web libraries."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from interop_web.web_peers import WebPeers, packages_or_skip


@pytest.fixture(scope="session")
def node_modules() -> Path:
    """The installed npm packages."""
    return packages_or_skip()


@pytest_asyncio.fixture
async def web_peers(node_modules: Path, tmp_path: Path) -> AsyncIterator[WebPeers]:
    """Starts programs of `peers/`; they end with the test."""
    peers = WebPeers(node_modules, tmp_path / "web_peers")
    yield peers
    await peers.close()


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs Node; the first test of a run also waits for npm."""
    item.add_marker("web")
    item.add_marker(pytest.mark.timeout(240))
