"""The platform's nodes as `rostether run` starts them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest_asyncio

from rostether.graph.typed_graph import TypedGraph
from rostether.joining import join
from rostether.ros1.master.server import MasterServer
from unit.cli.serving_process import started


@pytest_asyncio.fixture
async def master() -> AsyncIterator[MasterServer]:
    master = await MasterServer.start(port=0)
    try:
        yield master
    finally:
        await master.close()


@pytest_asyncio.fixture
async def graph(master: MasterServer) -> AsyncIterator[TypedGraph]:
    async with join("test", environ={"ROS_MASTER_URI": master.uri}) as graph:
        yield graph


async def test_arduino_control(master: MasterServer, graph: TypedGraph) -> None:
    joy = await graph.publisher("/joy", "sensor_msgs/Joy", latch=True)
    joy.publish(axes=[0.05, 0.0])
    # The parameter is where the platform's first node reads it.
    await graph.set_param("/arduino_control/deadzone", 0.01)
    async with started("run", "arduino_control", "arduino_control", ROS_MASTER_URI=master.uri):
        async with asyncio.timeout(60):
            async for command in graph.messages("/arduino_control"):
                assert 0.0499 < command.speed < 0.0501
                break


async def test_a_parameter_that_is_no_number(master: MasterServer) -> None:
    async with started("role", "arduino-control", "_deadzone:=wide", ROS_MASTER_URI=master.uri) as node:
        assert await asyncio.wait_for(node.process.wait(), 60) == 1
        await node.wait_for("rostether: error: ~deadzone must be a number, not 'wide'")
