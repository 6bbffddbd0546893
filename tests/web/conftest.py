"""Fixtures of the tests of the dashboard's page in a real browser."""

from __future__ import annotations

import subprocess
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from web.browser import Browser, page_packages
from web.robot import Robot


@pytest.fixture(scope="session")
def packages() -> Path:
    """A folder whose node_modules has playwright-core."""
    try:
        return page_packages()
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        pytest.skip(f"npm ci failed, is the network up? {error}")


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def chromium(packages: Path) -> AsyncIterator[Browser]:
    """The browser of this test process."""
    browser = await Browser.start(packages)
    yield browser
    await browser.close()


@pytest_asyncio.fixture(loop_scope="session")
async def browser(chromium: Browser) -> AsyncIterator[Browser]:
    """Chromium; after each test, its pages and their stored data are closed."""
    yield chromium
    await chromium.do("closeAll")


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def board(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Robot]:
    """The board and dashboard of the tests of a file."""
    robot = Robot(tmp_path_factory.mktemp("robot"))
    try:
        await robot.start()
        yield robot
    finally:
        await robot.close()


@pytest_asyncio.fixture(loop_scope="session")
async def robot(board: Robot) -> Robot:
    """A simulated board, and the dashboard without options."""
    await board.restore_dashboard()
    return board


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs Node and a browser."""
    item.add_marker("web")
    item.add_marker("browser")
    item.add_marker(pytest.mark.timeout(300))
