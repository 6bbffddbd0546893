"""Boards through the bridge with Debian's tools and nodes: devices over TCP, a real master."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.device.device import Device
from rostether.errors import ServiceTimeoutError
from rostether.graph.ports import Graph
from rostether.msgdef.registry import Registry
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.node import join_ros1
from rostether.serde.store import TypeStore
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from waiting import until

STORE = TypeStore(Registry())

LOG_ECHO = """
import rospy
from rosgraph_msgs.msg import Log
rospy.init_node("py_log")
def handle(log):
    if log.name == "/arm" and log.msg == "battery low":
        print(log.level, log.msg, flush=True)
        rospy.signal_shutdown("done")
rospy.Subscriber("/rosout", Log, handle)
print("listening", flush=True)
rospy.spin()
"""

SERVER = """
import rospy
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node("py_service")
rospy.Service("/gripper", SetBool, lambda request: SetBoolResponse(request.data, "gripped"))
print("serving", flush=True)
rospy.spin()
"""


# In the order of the master's answer.
REGISTERED = ("publisher", "subscriber", "service server")


class BridgeStage:
    """A stage with a bridge, and devices at its TCP port."""

    def __init__(self, stage: Stage, service_timeout_s: float = 60.0) -> None:
        self.stage = stage
        self.peers = stage.peers
        self.reporter = RecordingReporter()
        self.supervisor = Supervisor(
            self.join,
            STORE,
            reporter=self.reporter,
            settings=BridgeSettings(grace_s=1.0, service_timeout_s=service_timeout_s),
        )
        self._stack = contextlib.AsyncExitStack()

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> Graph:
        return await join_ros1(
            node_name,
            environment=RosEnvironment.read({}).with_master(self.peers.master_uri),
            namespace=namespace,
            remappings=remappings,
        )

    async def open(self) -> BridgeStage:
        await self.supervisor.start([parse_address("tcp://127.0.0.1:0?name=arm")])
        return self

    async def device(self) -> Device:
        """Connect another device; the caller declares its endpoints afterwards."""
        return await self._stack.enter_async_context(Device(self.supervisor.listening_on[0], store=STORE))

    async def close(self) -> None:
        await self._stack.aclose()
        await self.supervisor.close()

    def has_endpoint(self, role: str, name: str) -> bool:
        return any(
            (each.role, each.name, each.is_attached) == (role, name, True)
            for view in self.supervisor.boards()
            for each in view.endpoints
        )

    async def wait_for_endpoint(self, role: str, name: str) -> None:
        """Wait until a board has an endpoint, and the master has its registration."""
        await until(lambda: self.has_endpoint(role, name), f"{role} {name}")
        if role not in REGISTERED:
            return
        master = MasterClient(self.peers.master_uri, "/test")
        async with asyncio.timeout(60):
            while f"/{name}" not in (await master.system_state())[REGISTERED.index(role)]:
                await asyncio.sleep(0.01)
        await master.close()


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


@pytest_asyncio.fixture
async def bridged(stage: Stage) -> AsyncIterator[BridgeStage]:
    bridged = BridgeStage(stage)
    await bridged.open()
    yield bridged
    await bridged.close()


async def publish_until_stopped(publisher: Any, **fields: Any) -> None:
    while True:
        publisher.publish(**fields)
        await asyncio.sleep(0.02)


@ON_BOTH_MASTERS
async def test_rostopic_echoes_a_boards_topic(bridged: BridgeStage) -> None:
    device = await bridged.device()
    publishing = asyncio.ensure_future(
        publish_until_stopped(device.publisher("chatter", "std_msgs/String"), data="hi")
    )
    await bridged.wait_for_endpoint("publisher", "chatter")
    assert (
        await bridged.peers.run("rostopic", "echo", "-n", "2", "/chatter")
        == 'data: "hi"\n---\ndata: "hi"\n---'
    )
    assert await bridged.peers.run("rostopic", "type", "/chatter") == "std_msgs/String"
    info = await bridged.peers.run("rostopic", "info", "/chatter")
    assert " * /arm (http://" in info
    publishing.cancel()


@ON_BOTH_MASTERS
async def test_rostopic_publishes_to_a_board(bridged: BridgeStage) -> None:
    device = await bridged.device()
    received: list[Any] = []
    device.subscriber("velocity", "geometry_msgs/Twist", received.append)
    await bridged.wait_for_endpoint("subscriber", "velocity")
    await bridged.peers.run(
        "rostopic", "pub", "-1", "/velocity", "geometry_msgs/Twist", "{linear: {x: 0.25}}"
    )
    await until(lambda: received, "the message")
    assert received[0].linear.x == 0.25


async def test_a_latched_message_reaches_a_board_that_connects_later(bridged: BridgeStage) -> None:
    await bridged.peers.start("rostopic", "pub", "-l", "/mode", "std_msgs/UInt8", "7")
    device = await bridged.device()
    received: list[Any] = []
    device.subscriber("mode", "std_msgs/UInt8", received.append)
    await until(lambda: received, "the latched message")
    assert received[0].data == 7


@ON_BOTH_MASTERS
async def test_rosservice_calls_a_board(bridged: BridgeStage) -> None:
    device = await bridged.device()
    device.service_server(
        "switch", "std_srvs/SetBool", lambda request: {"success": request.data, "message": "done"}
    )
    await bridged.wait_for_endpoint("service server", "switch")
    called = await bridged.peers.run("rosservice", "call", "/switch", "true")
    assert called == 'success: True\nmessage: "done"'
    assert await bridged.peers.run("rosservice", "type", "/switch") == "std_srvs/SetBool"


async def test_rosservice_shows_why_a_board_did_not_answer(stage: Stage) -> None:
    bridged = await BridgeStage(stage, service_timeout_s=2.0).open()
    device = await bridged.device()

    async def hang(_request: Any) -> None:
        await asyncio.sleep(60.0)

    device.service_server("switch", "std_srvs/SetBool", hang)
    await bridged.wait_for_endpoint("service server", "switch")
    for _ in range(10):
        failed = await bridged.peers.run("rosservice", "call", "/switch", "true", check=False)
        # On a busy machine, the board may lose its connection during the call.
        if "the board was reset" not in failed:
            break
    assert "the board did not answer switch within 2 s" in failed
    await bridged.close()


async def test_a_board_calls_a_rospy_service(bridged: BridgeStage) -> None:
    device = await bridged.device()
    client = device.service_client("gripper", "std_srvs/SetBool")
    server = await bridged.peers.rospy(SERVER)
    await server.wait_for("serving")
    await bridged.wait_for_endpoint("service client", "gripper")
    response = await client.call(data=True)
    assert (response.success, response.message) == (True, "gripped")


async def test_a_call_without_a_server_fails(bridged: BridgeStage) -> None:
    device = await bridged.device()
    client = device.service_client("no_server", "std_srvs/SetBool")
    await bridged.wait_for_endpoint("service client", "no_server")
    try:
        response = await client.call(data=True)
        assert (response.success, response.message) == (False, "")
    except ServiceTimeoutError:
        pytest.fail("the board waited")
    assert len(bridged.reporter.having("no_server")) >= 1


@ON_BOTH_MASTERS
async def test_a_board_gets_parameters_of_rosparam(bridged: BridgeStage) -> None:
    for name, value in (
        ("/gain", "2.5"),
        ("/count", "42"),
        ("/side", "left"),
        ("/flags", "[true, false]"),
        ("/arm/own", "[1.5, 2.5]"),
    ):
        await bridged.peers.run("rosparam", "set", name, value)
    device = await bridged.device()
    await device.wait_connected(60.0)
    values = [await device.get_param(name) for name in ("gain", "count", "/side", "flags", "~own")]
    assert values == [2.5, 42, "left", [1, 0], [1.5, 2.5]]


async def test_a_boards_log_is_in_rosout_under_its_name(bridged: BridgeStage) -> None:
    listener = await bridged.peers.rospy(LOG_ECHO)
    await listener.wait_for("listening")
    device = await bridged.device()
    await device.wait_connected(60.0)
    async with asyncio.timeout(60):
        while listener.process.returncode is None:
            device.logwarn("battery low")
            await asyncio.sleep(0.1)
    assert "4 battery low" in listener.text


async def test_rosnode_lists_each_board_and_kills_one_until_it_reconnects(bridged: BridgeStage) -> None:
    first, second = await bridged.device(), await bridged.device()
    first.publisher("first", "std_msgs/String")
    second.publisher("second", "std_msgs/String")
    await bridged.wait_for_endpoint("publisher", "first")
    await bridged.wait_for_endpoint("publisher", "second")
    nodes = (await bridged.peers.run("rosnode", "list")).splitlines()
    assert {"/arm", "/arm_2"} <= set(nodes)
    assert "xmlrpc reply from" in await bridged.peers.run("rosnode", "ping", "-c", "1", "/arm")
    await bridged.peers.run("rosnode", "kill", "/arm_2")
    await until(lambda: bridged.reporter.having("not served until it reconnects"), "one board to go")
    # The device reconnects automatically.
    await until(lambda: len(bridged.supervisor.boards()) == 2, "the board to come back")
    await bridged.wait_for_endpoint("publisher", "second")
    assert sorted(view.node for view in bridged.supervisor.boards()) == ["/arm", "/arm_2"]
    assert "xmlrpc reply from" in await bridged.peers.run("rosnode", "ping", "-c", "1", "/arm_2")


async def test_a_subscriber_still_receives_from_a_board_that_reconnected(bridged: BridgeStage) -> None:
    device = await bridged.device()
    device.publisher("counter", "std_msgs/String")
    await bridged.wait_for_endpoint("publisher", "counter")
    echo = await bridged.peers.start("rostopic", "echo", "/counter/data")
    await device.close()
    again = await bridged.device()
    publishing = asyncio.ensure_future(
        publish_until_stopped(again.publisher("counter", "std_msgs/String"), data="back")
    )
    await echo.wait_for("back")
    publishing.cancel()


async def test_closing_removes_all_registrations_from_the_master(stage: Stage) -> None:
    bridged = await BridgeStage(stage).open()
    device = await bridged.device()
    device.publisher("chatter", "std_msgs/String")
    device.service_server("switch", "std_srvs/SetBool", lambda request: {})
    await bridged.wait_for_endpoint("service server", "switch")
    await bridged.wait_for_endpoint("publisher", "chatter")
    await bridged.close()
    assert "/chatter" not in (await stage.peers.run("rostopic", "list")).splitlines()
    assert "/switch" not in (await stage.peers.run("rosservice", "list")).splitlines()
    assert "/arm" not in (await stage.peers.run("rosnode", "list")).splitlines()
