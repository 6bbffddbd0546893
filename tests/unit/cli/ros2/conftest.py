from __future__ import annotations

import importlib.util
from collections.abc import Iterator

import pytest

from unit.cli.ros2.zenoh_world import ZenohWorld


@pytest.fixture(scope="module")
def zenoh_world() -> Iterator[ZenohWorld]:
    """One graph for all tests of a file."""
    if importlib.util.find_spec("zenoh") is None:
        pytest.skip('zenoh is not installed (pip install "rostether[zenoh]")')
    world = ZenohWorld()
    try:
        yield world
    finally:
        world.close()


@pytest.fixture
def world(zenoh_world: ZenohWorld, monkeypatch: pytest.MonkeyPatch) -> ZenohWorld:
    """A graph over zenoh, which commands with `--ros2 zenoh` join."""
    for name in ("ROS_DOMAIN_ID", "ROS_VERSION", "ZENOH_SESSION_CONFIG_URI", "ZENOH_ROUTER_CONFIG_URI"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", f'connect/endpoints=["tcp/127.0.0.1:{zenoh_world.port}"]')
    zenoh_world.received.clear()
    return zenoh_world
