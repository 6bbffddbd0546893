"""ROS time on ROS 2, which the parameter use_sim_time switches at any time."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from rostether.errors import GraphError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Publisher
from rostether.graph.ros_clock import CLOCK_TOPIC, CLOCK_TYPE
from rostether.ros2.clock import NodeClock
from rostether.ros2.parameters.store import ParameterStore
from rostether.ros2.parameters.typed_value import typed_value
from rostether.rostime import Time
from waiting import until

WALL = Time(1_700_000_000, 5)


class Setting:
    """A node and a simulator."""

    def __init__(self, node: MemoryGraph, simulator: Publisher) -> None:
        self.node = node
        self.simulator = simulator

    def simulate(self, store: ParameterStore, *, is_on: bool) -> None:
        store.apply({"use_sim_time": typed_value("", is_on)})

    def tick(self, secs: int) -> None:
        self.simulator.publish_raw([struct.pack("<II", secs, 7)])


@pytest_asyncio.fixture
async def setting() -> AsyncIterator[Setting]:
    network = MemoryNetwork()
    node, simulator = await network.join("/node"), await network.join("/simulator")
    yield Setting(node, await simulator.advertise(CLOCK_TOPIC, CLOCK_TYPE))
    await node.close()
    await simulator.close()


async def test_wall_time_needs_no_clock(setting: Setting) -> None:
    clock = NodeClock(ParameterStore(), setting.node, lambda: WALL)
    await clock.open()
    assert clock.now() == WALL
    assert setting.simulator.subscriber_count == 0
    await clock.close()
    await clock.close()


async def test_simulated_time_from_the_start(setting: Setting) -> None:
    clock = NodeClock(ParameterStore({"use_sim_time": True}), setting.node, lambda: WALL)
    await clock.open()
    assert clock.now() == Time()
    setting.tick(12)
    await until(lambda: clock.now() == Time(12, 7))
    setting.simulator.publish_raw([b"too short"])
    setting.tick(13)
    await until(lambda: clock.now() == Time(13, 7))
    await clock.close()
    assert setting.simulator.subscriber_count == 0


async def test_time_switches_with_the_parameter(setting: Setting) -> None:
    store = ParameterStore()
    clock = NodeClock(store, setting.node, lambda: WALL)
    await clock.open()
    for _ in range(2):
        setting.simulate(store, is_on=True)
        assert clock.now() == Time()
        await until(lambda: setting.simulator.subscriber_count == 1)
        setting.tick(12)
        await until(lambda: clock.now() == Time(12, 7))
        setting.simulate(store, is_on=False)
        assert clock.now() == WALL
        await until(lambda: setting.simulator.subscriber_count == 0)
    await clock.close()
    setting.simulate(store, is_on=True)
    await asyncio.sleep(0)
    assert setting.simulator.subscriber_count == 0


async def test_after_quick_switches_the_clock_matches_the_parameter(setting: Setting) -> None:
    store = ParameterStore()
    clock = NodeClock(store, setting.node, lambda: WALL)
    await clock.open()
    for is_on in (True, False, True):
        setting.simulate(store, is_on=is_on)
    await until(lambda: setting.simulator.subscriber_count == 1)
    for is_on in (False, True, False):
        setting.simulate(store, is_on=is_on)
    await until(lambda: setting.simulator.subscriber_count == 0)
    assert clock.now() == WALL
    await clock.close()


async def test_a_graph_that_refuses_is_reported(setting: Setting, caplog: pytest.LogCaptureFixture) -> None:
    store = ParameterStore()
    clock = NodeClock(store, setting.node, lambda: WALL)
    await clock.open()
    await setting.node.close()
    setting.simulate(store, is_on=True)
    await until(lambda: "/node cannot follow /clock" in caplog.text)
    await clock.close()
    with pytest.raises(GraphError):
        await NodeClock(ParameterStore({"use_sim_time": True}), setting.node).open()
