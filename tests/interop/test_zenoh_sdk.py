"""Nodes over zenoh with zenoh-ros2-sdk, another implementation of rmw_zenoh's conventions."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import Inbox, string, wait_for_snapshot
from contract.zenoh_graphs import open_router
from interop.zenoh_peers import SdkPeer, missing_sdk, sdk_peer
from rostether.errors import ServiceCallError, ServiceTimeoutError
from rostether.graph.ports import Graph
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.msgdef.registry import Registry
from rostether.ros2.zenoh.session import ZenohSession
from rostether.serde.store import TypeStore
from waiting import until

pytestmark = pytest.mark.skipif(bool(missing_sdk()), reason=missing_sdk())

DOMAIN = 7
REGISTRY = Registry()
STORE = TypeStore(REGISTRY)
STRING = REGISTRY.message_type("std_msgs/String")
RANGE = REGISTRY.message_type("sensor_msgs/Range")
SET_BOOL = REGISTRY.service_type("std_srvs/SetBool")
STRING_TEXT = "string data\n"
RANGE_TEXT = """std_msgs/Header header
uint8 radiation_type
float32 field_of_view
float32 min_range
float32 max_range
float32 range
float32 variance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


@pytest_asyncio.fixture
async def session() -> AsyncIterator[ZenohSession]:
    """A session of rostether, which is a router on a free port."""
    session, _ = await open_router(DOMAIN)
    yield session
    await session.close()


@pytest_asyncio.fixture
async def node(session: ZenohSession) -> Graph:
    """A node of rostether."""
    return await session.join("board", namespace="/lab")


@pytest_asyncio.fixture
async def peer(session: ZenohSession, tmp_path: Path) -> AsyncIterator[SdkPeer]:
    """A peer with zenoh-ros2-sdk, which uses the session as its router."""
    (endpoint,) = session.listens_on
    port = int(endpoint.rpartition(":")[2])
    async with sdk_peer(port, tmp_path, DOMAIN) as peer:
        yield peer


async def test_publisher_to_sdk_subscriber(node: Graph, peer: SdkPeer) -> None:
    publisher = await node.advertise("/chat", STRING)
    await peer.do("subscribe", "/chat", msg_type="std_msgs/msg/String", msg_definition=STRING_TEXT)
    await until(lambda: publisher.subscriber_count == 1)
    texts = [f"message {number} ä" for number in range(500)]
    publisher.publish_raw([string(text) for text in texts])
    await until(lambda: len(peer.received) == 500)
    assert [fields["data"] for fields in peer.received] == texts


async def test_sdk_publisher_to_subscriber(node: Graph, peer: SdkPeer) -> None:
    inbox = Inbox()
    await node.subscribe("/chat", STRING, inbox.store, on_connection=inbox.store_header)
    await peer.do(
        "advertise", "/chat", msg_type="std_msgs/msg/String", msg_definition=STRING_TEXT, node_name="talker"
    )
    await until(lambda: inbox.headers)
    assert inbox.headers[0]["callerid"] == "/talker"
    texts = [f"message {number} ä" for number in range(500)]
    await peer.do("publish", "/chat", messages=[{"data": text} for text in texts])
    await until(lambda: len(inbox.payloads) == 500)
    assert inbox.payloads == [string(text) for text in texts]


async def test_stamped_messages_are_exchanged(node: Graph, session: ZenohSession, peer: SdkPeer) -> None:
    # The peer uses rostether's hash: its own implementation needs definitions from the internet.
    kind = {
        "msg_type": "sensor_msgs/msg/Range",
        "msg_definition": RANGE_TEXT,
        "type_hash": session.types.message(RANGE).type_hash,
    }
    codec = STORE.codec("sensor_msgs/Range")
    publisher, inbox = await node.advertise("/to_sdk", RANGE), Inbox()
    await node.subscribe("/back", ANY_MESSAGE, inbox.store)
    await peer.do("subscribe", "/to_sdk", **kind)
    await peer.do("advertise", "/back", **kind)
    await until(lambda: publisher.subscriber_count == 1)
    header = {"stamp": {"sec": 12, "nanosec": 34}, "frame_id": "sonar"}
    fields = {
        "radiation_type": 1,
        "field_of_view": 0.5,
        "min_range": 0.25,
        "max_range": 4.0,
        "range": 1.5,
    }
    ros1 = codec.encode(
        {**fields, "header": {"seq": 9, "stamp": {"secs": 12, "nsecs": 34}, "frame_id": "sonar"}}
    )
    publisher.publish_raw([ros1])
    await until(lambda: peer.received)
    received = peer.received[0]
    assert {name: received[name] for name in fields} == fields
    assert received["header"] == header
    await peer.do("publish", "/back", messages=[{**fields, "variance": 0.0, "header": header}])
    await until(lambda: inbox.payloads)
    # The same except for seq, which ROS 2 does not have.
    assert inbox.payloads[0] == bytes(4) + ros1[4:]


async def test_latched_topic_to_sdk_subscriber(node: Graph, peer: SdkPeer) -> None:
    publisher = await node.advertise("/map", STRING, latch=True)
    publisher.publish_raw([string("old"), string("new")])
    await peer.do(
        "subscribe",
        "/map",
        msg_type="std_msgs/msg/String",
        msg_definition=STRING_TEXT,
        qos=":1:,1:,:,:,,",
    )
    await until(lambda: peer.received)
    publisher.publish_raw([string("newer")])
    await until(lambda: len(peer.received) == 2)
    assert [fields["data"] for fields in peer.received] == ["new", "newer"]


async def test_service_called_by_sdk(node: Graph, peer: SdkPeer) -> None:
    async def answer(request: bytes) -> bytes:
        return request + string("is it")

    await node.advertise_service("/switch", SET_BOOL, answer)
    definitions = {"request_definition": "bool data", "response_definition": "bool success\nstring message"}
    for data in (True, False):
        answered = await peer.do(
            "call", "/switch", srv_type="std_srvs/srv/SetBool", request={"data": data}, **definitions
        )
        assert {key: answered["response"][key] for key in ("success", "message")} == {
            "success": data,
            "message": "is it",
        }


async def test_service_of_sdk_called(node: Graph, peer: SdkPeer) -> None:
    definitions = {"request_definition": "bool data", "response_definition": "bool success\nstring message"}
    await peer.do("serve", "/switch", srv_type="std_srvs/srv/SetBool", answer="you said ", **definitions)
    response = await node.call_service("/switch", SET_BOOL, b"\x01", timeout_s=60)
    assert response == b"\x01" + string("you said True")
    assert await node.call_service("/switch", SET_BOOL, b"\x00") == b"\x00" + string("you said False")
    await peer.do("close", "srv /switch")
    with pytest.raises((ServiceCallError, ServiceTimeoutError)):
        await node.call_service("/switch", SET_BOOL, b"\x01", timeout_s=2.0)


async def test_nodes_and_topics_of_both_are_listed(node: Graph, session: ZenohSession, peer: SdkPeer) -> None:
    await node.advertise("/from_board", STRING)
    await node.subscribe("/back", STRING, Inbox().store)
    await peer.do(
        "advertise",
        "/from_sdk",
        msg_type="std_msgs/msg/String",
        msg_definition=STRING_TEXT,
        node_name="talker",
        namespace="/far",
    )
    # The peer discovers its own topics like those of others.
    async with asyncio.timeout(60):
        while not {"/from_board", "/from_sdk"} <= (topics := (await peer.do("topics"))["topics"]).keys():
            await asyncio.sleep(0.02)
    assert topics["/from_board"] == topics["/from_sdk"] == ["std_msgs/msg/String"]
    assert topics["/rosout"] == ["rcl_interfaces/msg/Log"]
    info = (await peer.do("topic", "/from_board"))["info"]
    (publisher,) = info["publishers"]
    assert (publisher["node_namespace"].strip("/"), publisher["node_name"].strip("/")) == ("lab", "board")
    assert publisher["type_hash"] == session.types.message(STRING).type_hash
    snapshot = await wait_for_snapshot(
        node, lambda seen: "/from_sdk" in seen.topics and seen.topics["/from_sdk"].publishers
    )
    assert {"/lab/board", "/far/talker"} <= set(snapshot.nodes)
    assert snapshot.topics["/from_sdk"].publishers == ("/far/talker",)
    assert snapshot.topics["/from_sdk"].type == "std_msgs/msg/String"
    await peer.close()
    changes = node.changes()
    async for snapshot in changes:
        if "/far/talker" not in snapshot.nodes:
            break
    await changes.aclose()  # type: ignore[attr-defined]
