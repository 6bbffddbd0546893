"""Boards through the bridge with a real ROS 2 node: devices over TCP, the graph over rclpy."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio

from interop_ros2.rclpy_peer import RclpyPeer
from interop_ros2.samples import MESSAGES, ros2_name, with_times, without_seq
from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.device.device import Device
from rostether.ros2.rclpy.context import RclpyContext
from rostether.serde.plain_form import to_plain
from rostether.serde.store import TypeStore
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from waiting import until

pytestmark = [pytest.mark.rclpy, pytest.mark.asyncio(loop_scope="module")]


class Boards:
    """A bridge with a TCP port, and devices that are connected until the end of the file."""

    def __init__(self, context: RclpyContext, store: TypeStore) -> None:
        self.reporter = RecordingReporter()
        self.supervisor = Supervisor(
            context.join,
            store,
            reporter=self.reporter,
            settings=BridgeSettings(grace_s=1.0, service_timeout_s=60.0),
        )
        self._store = store
        self._stack = contextlib.AsyncExitStack()

    async def connect(self) -> Device:
        """Connect another device; the caller declares its endpoints afterwards."""
        device = Device(self.supervisor.listening_on[0], store=self._store)
        return await self._stack.enter_async_context(device)

    async def wait_for_endpoint(self, role: str, name: str) -> str:
        """Wait until an endpoint is in the graph; return its board's node."""

        def nodes() -> list[str]:
            return [
                view.node
                for view in self.supervisor.boards()
                for each in view.endpoints
                if (each.role, each.name, each.is_attached) == (role, name, True)
            ]

        await until(nodes, f"{role} {name}")
        return nodes()[0]

    async def close(self) -> None:
        await self._stack.aclose()
        await self.supervisor.close()


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def boards(context: RclpyContext, store: TypeStore) -> AsyncIterator[Boards]:
    boards = Boards(context, store)
    await boards.supervisor.start([parse_address("tcp://127.0.0.1:0?name=arm")])
    yield boards
    await boards.close()


async def test_boards_publish_to_rclpy(boards: Boards, peer: RclpyPeer) -> None:
    device = await boards.connect()
    for name in MESSAGES:
        topic = f"out_{name.partition('/')[2]}"
        await peer.ask("subscribe", topic=f"/{topic}", type=ros2_name(name))
        publisher = device.publisher(topic, name)
        await boards.wait_for_endpoint("publisher", topic)
        while not (received := await peer.ask("receive", topic=f"/{topic}", count=0)):
            publisher.publish(**with_times(MESSAGES[name]))
            await asyncio.sleep(0.02)
        for field, value in MESSAGES[name].items():
            assert received[0][field] == value


async def test_rclpy_publishes_to_boards(boards: Boards, peer: RclpyPeer) -> None:
    device = await boards.connect()
    for name in MESSAGES:
        topic = f"in_{name.partition('/')[2]}"
        received: list[Any] = []
        device.subscriber(topic, name, received.append)
        await boards.wait_for_endpoint("subscriber", topic)
        await peer.ask("advertise", topic=f"/{topic}", type=ros2_name(name))
        await peer.ask("publish", topic=f"/{topic}", messages=[MESSAGES[name]])
        await until(lambda: received, name)  # noqa: B023 - awaited at once
        assert without_seq(to_plain(received[0])) == MESSAGES[name]


async def test_rclpy_calls_a_board(boards: Boards, peer: RclpyPeer) -> None:
    device = await boards.connect()
    device.service_server(
        "switch", "std_srvs/SetBool", lambda request: {"success": request.data, "message": "done"}
    )
    device.service_server("pull", "std_srvs/Trigger", lambda _: {"success": True, "message": "bang"})
    await boards.wait_for_endpoint("service server", "switch")
    await boards.wait_for_endpoint("service server", "pull")
    called = await peer.ask("call", service="/switch", type="std_srvs/srv/SetBool", request={"data": True})
    assert called == {"success": True, "message": "done"}
    called = await peer.ask("call", service="/pull", type="std_srvs/srv/Trigger", request={})
    assert called == {"success": True, "message": "bang"}


async def test_a_board_calls_rclpy(boards: Boards, peer: RclpyPeer) -> None:
    response = {"success": True, "message": "gripped"}
    await peer.ask("serve", service="/gripper", type="std_srvs/srv/SetBool", response=response)
    device = await boards.connect()
    client = device.service_client("gripper", "std_srvs/SetBool")
    node = await boards.wait_for_endpoint("service client", "gripper")
    # Listed before its first call, as soon as the peer has discovered the node.
    while [node.removeprefix("/"), "/"] not in await peer.ask("nodes"):
        await asyncio.sleep(0.01)
    while ["/gripper", ["std_srvs/srv/SetBool"]] not in (
        await peer.ask("endpoints_of_node", name=node.removeprefix("/"), namespace="/")
    )["clients"]:
        await asyncio.sleep(0.01)
    received = await client.call(data=True)
    assert (received.success, received.message) == (True, "gripped")
    assert await peer.ask("received_requests", service="/gripper") == [{"data": True}]


async def test_a_board_reads_the_parameters_of_its_node(boards: Boards, peer: RclpyPeer) -> None:
    device = await boards.connect()
    device.publisher("beacon", "std_msgs/Empty")
    node = await boards.wait_for_endpoint("publisher", "beacon")
    values = [("gain", 2.5), ("count", 42), ("side", "left"), ("flags", [True, False])]
    await peer.ask("parameters", node=node, method="set_parameters", arguments=values)
    read = [await device.get_param(name) for name in ("~gain", "count", "/side", "~flags")]
    assert read == [2.5, 42, "left", [1, 0]]


async def test_each_board_is_a_node(boards: Boards, peer: RclpyPeer) -> None:
    device = await boards.connect()
    device.publisher("own", "std_msgs/String")
    node = await boards.wait_for_endpoint("publisher", "own")
    while [node.removeprefix("/"), "/"] not in await peer.ask("nodes"):
        await asyncio.sleep(0.01)
    while True:
        seen = await peer.ask("endpoints_of_node", name=node.removeprefix("/"), namespace="/")
        if ["/own", ["std_msgs/msg/String"]] in seen["publishers"]:
            break
        await asyncio.sleep(0.01)


async def test_a_boards_log_is_in_rosout(boards: Boards, peer: RclpyPeer) -> None:
    await peer.ask("subscribe", topic="/rosout", type="rcl_interfaces/msg/Log", quality="rosout")
    device = await boards.connect()
    await device.wait_connected(60.0)
    device.logwarn("battery low")
    while True:
        logs = await peer.ask("receive", topic="/rosout", count=1)
        if any((log["level"], log["msg"]) == (30, "battery low") for log in logs):
            break
        device.logwarn("battery low")
        await asyncio.sleep(0.05)
