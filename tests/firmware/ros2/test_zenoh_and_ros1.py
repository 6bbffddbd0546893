"""Boards in ROS 1 and in ROS 2 over zenoh at the same time, from one `rostether serve`.

Debian's tools use them in ROS 1, zenoh-ros2-sdk and a rostether session in ROS 2.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Any

import pytest
import pytest_asyncio

from contract.graphs import Inbox, string
from contract.zenoh_graphs import open_session, ros2_types
from firmware.ros2.mirrored import MIRROR, MIRRORED, NAMES
from firmware.ros2.serving import serving, sim_address
from interop.ros1_peers import Ros1Peers, free_port
from interop.zenoh_peers import SdkPeer, missing_sdk, sdk_peer
from interop_ros2.samples import with_times, without_seq
from programs import Peer
from rostether.graph.ports import Graph, ParamValue
from rostether.mechanisms.block_end import closed_at_end
from rostether.msgdef.registry import Registry
from rostether.serde.plain_form import to_plain
from rostether.serde.store import TypeStore
from waiting import until

pytestmark = [
    pytest.mark.ros1,
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.timeout(300),
    pytest.mark.skipif(bool(missing_sdk()), reason=missing_sdk()),
]

DOMAIN = 9
TIMEOUT_S = 60.0
STORE = TypeStore(Registry())
STRING = STORE.registry.message_type("std_msgs/String")
EMPTY = STORE.registry.message_type("std_msgs/Empty")
TF_TEXT = """geometry_msgs/TransformStamped[] transforms
================================================================================
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1
"""
# As `ros2 topic info -v /tf` of Jazzy prints it: tf2_msgs is in no package index.
TF_HASH = "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"


@dataclass
class World:
    """The bridge with the boards `/lab/arm` and `/frames`, and the programs that use them."""

    bridge: Peer
    ros1: Ros1Peers
    ros2: Graph
    sdk: SdkPeer


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def world(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[World]:
    home = tmp_path_factory.mktemp("home")
    master, router = free_port(), free_port()
    addresses = [
        await sim_address(MIRROR, "mega", "arm") + "&ns=lab",
        await sim_address("TimeTF", "uno", "frames"),
    ]
    environment = {
        "ROS_MASTER_URI": f"http://localhost:{master}",
        "ROS_DOMAIN_ID": str(DOMAIN),
        "ZENOH_CONFIG_OVERRIDE": f'listen/endpoints=["tcp/127.0.0.1:{router}"]',
    }
    async with AsyncExitStack() as stack:
        options = ("--ros1", "--ros2", "zenoh", "--zenoh-router", "always")
        bridge = await stack.enter_async_context(serving(*options, *addresses, environment=environment))
        await bridge.wait_for("/frames", TIMEOUT_S)
        session = await open_session(router, is_router=False, domain_id=DOMAIN)
        stack.push_async_callback(session.close)
        ros1 = Ros1Peers(environment["ROS_MASTER_URI"], home)
        stack.push_async_callback(ros1.close)
        sdk = await stack.enter_async_context(sdk_peer(router, home, DOMAIN))
        yield World(bridge, ros1, await session.join("/onlooker"), sdk)


async def send_and_receive(
    world: World, name: str, payload: bytes, input_topic: str, output_topic: str
) -> bytes:
    """Publish a message in ROS 2, and return the message that the board sends back."""
    message_type, inbox = STORE.registry.message_type(name), Inbox()
    await world.ros2.subscribe(output_topic, message_type, inbox.store, on_connection=inbox.store_header)
    publisher = await world.ros2.advertise(input_topic, message_type)
    await until(lambda: publisher.subscriber_count, f"a subscriber of {input_topic}")
    await until(lambda: inbox.headers, f"a publisher of {output_topic}")
    assert inbox.headers[0]["callerid"] == "/lab/arm"
    publisher.publish_raw([payload])
    await until(lambda: inbox.payloads)
    return inbox.payloads[0]


@pytest.mark.parametrize("name", NAMES)
async def test_messages_reach_the_board_and_come_back(world: World, name: str) -> None:
    short, codec = name.partition("/")[2], STORE.codec(name)
    payload = codec.encode(with_times(MIRRORED[name]))
    received = await send_and_receive(world, name, payload, f"/lab/in_{short}", f"/lab/out_{short}")
    assert without_seq(to_plain(codec.decode(received))) == MIRRORED[name]


async def test_sdk_receives_from_and_sends_to_the_board(world: World) -> None:
    kind = {"msg_type": "std_msgs/msg/String", "msg_definition": "string data\n"}
    await world.sdk.do("subscribe", "/lab/out_String", **kind)
    await world.sdk.do("advertise", "/lab/in_String", **kind)
    for number in range(100):
        await world.sdk.do("publish", "/lab/in_String", messages=[{"data": f"try {number}"}])
        if any(fields.get("data", "").startswith("try") for fields in world.sdk.received):
            break
        await asyncio.sleep(0.1)
    assert any(fields.get("data", "").startswith("try") for fields in world.sdk.received)


async def test_sdk_and_the_board_call_each_other(world: World) -> None:
    definitions = {"request_definition": "bool data", "response_definition": "bool success\nstring message"}
    answered = await world.sdk.do(
        "call", "/lab/switch", srv_type="std_srvs/srv/SetBool", request={"data": True}, **definitions
    )
    assert (answered["response"]["success"], answered["response"]["message"]) == (True, "on")
    await world.sdk.do(
        "serve", "/lab/gripper", srv_type="std_srvs/srv/SetBool", answer="said ", **definitions
    )

    async def honk(_request: bytes) -> bytes:
        return b"\x01" + string("honked")

    trigger = STORE.registry.service_type("std_srvs/Trigger")
    expected = [string("said True"), string("honked")]
    inbox = Inbox()
    async with closed_at_end(await world.ros2.advertise_service("/lab/horn", trigger, honk)):
        await world.ros2.subscribe("/lab/answers", STRING, inbox.store, on_connection=inbox.store_header)
        call = await world.ros2.advertise("/lab/call", EMPTY)
        await until(lambda: call.subscriber_count and inbox.headers)
        async with asyncio.timeout(TIMEOUT_S):
            while inbox.payloads[-2:] != expected:
                # A call fails until the bridge has discovered the server.
                call.publish_raw([b""])
                await asyncio.sleep(1.0)


async def test_frames_have_the_type_of_tf2(world: World) -> None:
    assert ros2_types().by_name("tf2_msgs/msg/TFMessage").type_hash == TF_HASH
    kind = {"msg_type": "tf2_msgs/msg/TFMessage", "msg_definition": TF_TEXT, "type_hash": TF_HASH}
    await world.sdk.do("subscribe", "/tf", **kind)

    def frames() -> list[Any]:
        return [fields["transforms"][0] for fields in world.sdk.received if "transforms" in fields]

    await until(frames)
    frame = frames()[0]
    assert (frame["header"]["frame_id"], frame["child_frame_id"]) == ("odom", "base_link")
    assert frame["transform"]["translation"] == {"x": 1.0, "y": 0.0, "z": 0.0}
    assert frame["header"]["stamp"]["sec"] > 1_700_000_000


async def test_sdk_lists_the_nodes_of_boards(world: World) -> None:
    info = (await world.sdk.do("topic", "/lab/out_Imu"))["info"]
    (publisher,) = info["publishers"]
    assert (publisher["node_namespace"].strip("/"), publisher["node_name"].strip("/")) == ("lab", "arm")
    topics = (await world.sdk.do("topics"))["topics"]
    assert topics["/tf"] == ["tf2_msgs/msg/TFMessage"]
    assert topics["/lab/out_Imu"] == ["sensor_msgs/msg/Imu"]


async def test_the_board_gets_parameters_of_ros2_and_logs_to_both_graphs(world: World) -> None:
    inbox, logs = Inbox(), Inbox()
    joint_state = STORE.registry.message_type("sensor_msgs/JointState")
    log = STORE.registry.message_type("rosgraph_msgs/Log")
    await world.ros2.subscribe("/rosout", log, logs.store)
    await world.ros2.subscribe("/lab/parameters", joint_state, inbox.store, on_connection=inbox.store_header)
    rosout = await world.ros1.start("rostopic", "echo", "/rosout")
    values: dict[str, ParamValue] = {"gains": [0.5, 0.25], "count": 42, "side": "left"}
    for name, value in values.items():
        await world.ros2.set_param(f"/lab/arm/{name}", value)
    read = await world.ros2.advertise("/lab/read", EMPTY)
    await until(lambda: read.subscriber_count and inbox.headers)
    read.publish_raw([b""])
    await until(lambda: inbox.payloads)
    reported = STORE.codec("sensor_msgs/JointState").decode(inbox.payloads[0])
    assert (reported.header.frame_id, reported.position) == ("left", [0.5, 0.25, 42.0])

    def texts() -> list[tuple[str, int]]:
        return [
            (each.msg, each.level) for each in map(STORE.codec("rosgraph_msgs/Log").decode, logs.payloads)
        ]

    await until(lambda: ("parameters are read", 4) in texts())
    while "parameters are read" not in rosout.text:
        read.publish_raw([b""])
        await asyncio.sleep(0.2)
    await rosout.stop()


async def test_debians_tools_use_the_same_board(world: World) -> None:
    assert {"/lab/arm", "/frames"} <= set((await world.ros1.run("rosnode", "list")).split())
    assert (await world.ros1.run("rostopic", "type", "/lab/out_Imu")).strip() == "sensor_msgs/Imu"
    printed = await world.ros1.run("rosservice", "call", "/lab/switch", "data: false")
    assert printed.split() == ["success:", "False", "message:", '"off"']
    inbox = Inbox()
    await world.ros2.subscribe("/lab/out_String", STRING, inbox.store, on_connection=inbox.store_header)
    await until(lambda: inbox.headers)
    echo = await world.ros1.start("rostopic", "echo", "/lab/out_String")
    talker = await world.ros1.start(
        "rostopic", "pub", "-r", "5", "/lab/in_String", "std_msgs/String", "data: from ROS 1"
    )
    # The board sends messages from ROS 1 back to both graphs.
    await echo.wait_for('data: "from ROS 1"', TIMEOUT_S)
    await until(lambda: string("from ROS 1") in inbox.payloads)
    await talker.stop()
    await echo.stop()
