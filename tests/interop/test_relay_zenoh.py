"""A relay between a ROS 1 graph and a graph over zenoh, each with ordinary nodes."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest
import pytest_asyncio

from contract.graphs import ADD_DIAGNOSTICS, Inbox, answer, string, wait_for_service, wait_for_snapshot
from contract.zenoh_graphs import open_session, ros2_types
from interop.ros1_peers import free_port
from rostether.cli.bridge.relay import finding_types
from rostether.graph.ports import Graph
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.msgdef.registry import Registry
from rostether.relay.relay import Relay
from rostether.relay.relay_filter import RelayFilter, ServiceFilter, TopicFilter
from rostether.relay.side import RelaySide
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from waiting import until

STORE = TypeStore(Registry())
CUSTOM = Registry(bundled=False)
CUSTOM.add_full_text("own_msgs/Reading", "float32 value\nstring unit\n")


class World:
    """A node in each graph, and a relay between the graphs."""

    def __init__(self, ros1: Graph, ros2: Graph, lines: list[str]) -> None:
        self.ros1 = ros1
        self.ros2 = ros2
        self.lines = lines


@pytest_asyncio.fixture
async def world() -> AsyncIterator[World]:
    lines: list[str] = []
    async with AsyncExitStack() as stack:
        master = await MasterServer.start(port=0)
        stack.push_async_callback(master.close)
        environment = RosEnvironment.read({}).with_master(master.uri)
        port = free_port()
        ros1_nodes, ros2_nodes = [], []
        for number, name in enumerate(("/relay", "/peer")):
            ros1_nodes.append(await join_ros1(name, environment=environment))
            stack.push_async_callback(ros1_nodes[-1].close)
            session = await open_session(port, is_router=number == 0)
            stack.push_async_callback(session.close)
            ros2_nodes.append(await session.join(name))
            stack.push_async_callback(ros2_nodes[-1].close)

        async def probe(_: str) -> str:
            return ADD_DIAGNOSTICS.name

        relay = Relay(
            RelaySide("ROS 1", ros1_nodes[0], finding_types(ros2_types(), probe)),
            RelaySide("ROS 2", ros2_nodes[0], finding_types(ros2_types())),
            RelayFilter((TopicFilter("*"),), (ServiceFilter("/add*"),)),
            lambda _level, line: lines.append(line),
        )
        running = asyncio.ensure_future(relay.run())
        try:
            yield World(ros1_nodes[1], ros2_nodes[1], lines)
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)


async def listen(target: Graph, topic: str, message_type: MessageType) -> Inbox:
    """Wait until the topic is relayed; return the target's inbox."""
    inbox = Inbox()
    await wait_for_snapshot(target, lambda seen: topic in seen.topics and seen.topics[topic].publishers)
    await target.subscribe(topic, message_type, inbox.store, on_connection=inbox.store_header)
    await until(lambda: inbox.headers)
    return inbox


@pytest.mark.parametrize("to_ros2", [True, False])
@pytest.mark.parametrize(
    ("type_name", "fields"),
    [
        ("sensor_msgs/Imu", {"header": {"frame_id": "base"}, "angular_velocity": {"z": 1.5}}),
        ("tf/tfMessage", {"transforms": [{"child_frame_id": "arm"}]}),
        ("std_msgs/Time", {}),
    ],
)
async def test_topics(world: World, type_name: str, fields: dict[str, object], *, to_ros2: bool) -> None:
    source, target = (world.ros1, world.ros2) if to_ros2 else (world.ros2, world.ros1)
    message_type = STORE.registry.message_type(type_name)
    message = STORE.codec(type_name).encode(fields)
    talker = await source.advertise("/data", message_type)
    inbox = await listen(target, "/data", message_type)
    await until(lambda: talker.subscriber_count)
    returned = Inbox()
    await source.subscribe("/data", message_type, returned.store)
    sent = 0

    async def keep_publishing() -> None:
        nonlocal sent
        while not inbox.payloads:
            talker.publish_raw([message])
            sent += 1
            await asyncio.sleep(0.02)

    await asyncio.wait_for(keep_publishing(), 60)
    assert inbox.payloads[0] == message
    # Each arrives once, and nothing comes back.
    await asyncio.sleep(0.1)
    assert len(inbox.payloads) <= sent
    assert len(returned.payloads) <= sent


async def test_a_latched_topic_of_a_type_that_only_its_publisher_knows(world: World) -> None:
    reading = CUSTOM.message_type("own_msgs/Reading")
    message = TypeStore(CUSTOM).codec("own_msgs/Reading").encode({"value": 1.5, "unit": "K"})
    talker = await world.ros1.advertise("/reading", reading, latch=True)
    talker.publish_raw([message])
    inbox = await listen(world.ros2, "/reading", reading)
    await until(lambda: inbox.payloads == [message])
    assert inbox.headers[0]["latching"] == "1"


async def test_a_subscriber_of_any_type_receives_ros2(world: World) -> None:
    text = STORE.registry.message_type("std_msgs/String")
    talker = await world.ros2.advertise("/text", text, latch=True)
    talker.publish_raw([string("hello")])
    inbox = await listen(world.ros1, "/text", ANY_MESSAGE)
    await until(lambda: inbox.payloads == [string("hello")])
    assert inbox.headers[0]["type"] == "std_msgs/String"


@pytest.mark.parametrize("to_ros2", [True, False])
async def test_services(world: World, *, to_ros2: bool) -> None:
    source, target = (world.ros1, world.ros2) if to_ros2 else (world.ros2, world.ros1)

    async def echo(request: bytes) -> bytes:
        return b"\1" + request

    await source.advertise_service("/add", ADD_DIAGNOSTICS, echo)
    await wait_for_service(target, "/add")
    called = await target.call_service("/add", ADD_DIAGNOSTICS, string("ns"), timeout_s=60)
    assert called == answer("ns")
