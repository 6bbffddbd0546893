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


@pytest_asyncio.fixture
async def browser(packages: Path) -> AsyncIterator[Browser]:
    """Chromium; it ends with the test."""
    browser = await Browser.start(packages)
    yield browser
    await browser.close()


@pytest_asyncio.fixture
async def robot(tmp_path: Path) -> AsyncIterator[Robot]:
    """A simulated board, and the dashboard beside it."""
    robot = Robot(tmp_path)
    await robot.start()
    yield robot
    await robot.close()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Everything in this folder needs Node and a browser."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker("web")
            item.add_marker("browser")
            item.add_marker(pytest.mark.timeout(300))
