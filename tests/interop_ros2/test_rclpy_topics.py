"""Topics between a node of rostether over rclpy and a plain rclpy node in another process."""

from __future__ import annotations

import asyncio
import os
import signal
from pathlib import Path
from typing import Any

import pytest

from contract.graphs import STRING, Inbox, string, wait_for_snapshot
from interop_ros2.rclpy_peer import PEER_NAME, RclpyPeer
from interop_ros2.samples import ADDED, MESSAGES, ros2_name, with_times, without_seq
from rostether.errors import UnknownTypeError
from rostether.graph.ports import JoinGraph, Level
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.ros2.rclpy.context import RclpyContext
from rostether.serde.plain_form import to_plain
from rostether.serde.store import TypeStore
from waiting import until

pytestmark = [pytest.mark.rclpy, pytest.mark.asyncio(loop_scope="module")]


def encode(store: TypeStore, name: str, values: Any) -> bytes:
    return store.codec(name).encode(with_times(values))


def decode(store: TypeStore, name: str, payload: bytes) -> Any:
    return without_seq(to_plain(store.codec(name).decode(payload)))


@pytest.mark.parametrize("name", MESSAGES)
async def test_publisher_to_rclpy_subscriber(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, name: str
) -> None:
    topic = f"/to_peer/{name.replace('/', '_')}"
    await peer.ask("subscribe", topic=topic, type=ros2_name(name))
    node = await join("/board")
    publisher = await node.advertise(topic, store.registry.message_type(name))
    await until(lambda: publisher.subscriber_count == 1)
    payload = encode(store, name, MESSAGES[name])
    publisher.publish_raw([payload] * 3)
    expected = {**MESSAGES[name], **ADDED.get(name, {})}
    assert await peer.ask("receive", topic=topic, count=3) == [expected] * 3


@pytest.mark.parametrize("name", MESSAGES)
async def test_rclpy_publisher_to_subscriber(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, name: str
) -> None:
    topic = f"/from_peer/{name.replace('/', '_')}"
    node, inbox = await join("/board"), Inbox()
    subscriber = await node.subscribe(
        topic, store.registry.message_type(name), inbox.store, on_connection=inbox.store_header
    )
    await peer.ask("advertise", topic=topic, type=ros2_name(name))
    await peer.ask("publish", topic=topic, messages=[MESSAGES[name]] * 3)
    await until(lambda: len(inbox.payloads) == 3)
    assert [decode(store, name, payload) for payload in inbox.payloads] == [MESSAGES[name]] * 3
    assert inbox.headers[0]["type"] == name
    await until(lambda: subscriber.publisher_count == 1)
    await peer.ask("unadvertise", topic=topic)
    await until(lambda: subscriber.publisher_count == 0)


async def test_a_burst_arrives_completely_and_in_order(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore
) -> None:
    node, inbox = await join("/board"), Inbox()
    string_type = store.registry.message_type("std_msgs/String")
    await peer.ask("subscribe", topic="/burst/out", type="std_msgs/msg/String")
    publisher = await node.advertise("/burst/out", string_type)
    await until(lambda: publisher.subscriber_count == 1)
    for start in range(0, 300, 100):
        publisher.publish_raw([string(f"message {number}") for number in range(start, start + 100)])
        received = await peer.ask("receive", topic="/burst/out", count=start + 100)
    assert received == [{"data": f"message {number}"} for number in range(300)]
    await node.subscribe("/burst/in", string_type, inbox.store)
    await peer.ask("advertise", topic="/burst/in", type="std_msgs/msg/String")
    # The peer's queue holds 100.
    for end in (100, 200, 300):
        await peer.ask("publish", topic="/burst/in", messages=received[end - 100 : end])
        await until(lambda: len(inbox.payloads) == end)  # noqa: B023
    assert inbox.payloads == [string(message["data"]) for message in received]


@pytest.mark.parametrize("is_first", [True, False])
async def test_a_subscriber_of_any_type_learns_the_type(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, is_first: bool
) -> None:
    topic = f"/any/{'first' if is_first else 'second'}"
    if not is_first:
        await peer.ask("advertise", topic=topic, type="sensor_msgs/msg/Range")
    node, inbox = await join("/board"), Inbox()
    await node.subscribe(topic, ANY_MESSAGE, inbox.store, on_connection=inbox.store_header)
    if is_first:
        await peer.ask("advertise", topic=topic, type="sensor_msgs/msg/Range")
    await peer.ask("publish", topic=topic, messages=[MESSAGES["sensor_msgs/Range"]])
    await until(lambda: inbox.payloads)
    assert decode(store, "sensor_msgs/Range", inbox.payloads[0]) == MESSAGES["sensor_msgs/Range"]
    (header,) = inbox.headers
    assert header["callerid"] == PEER_NAME
    assert header["type"] == "sensor_msgs/Range"
    await peer.ask("unadvertise", topic=topic)


async def test_best_effort_messages_are_exchanged(join: JoinGraph, peer: RclpyPeer, store: TypeStore) -> None:
    node, inbox = await join("/board"), Inbox()
    string_type = store.registry.message_type("std_msgs/String")
    # The subscription is reliable before a publisher exists, then it adapts.
    await node.subscribe("/sensor/in", string_type, inbox.store)
    await peer.ask("advertise", topic="/sensor/in", type="std_msgs/msg/String", quality="sensor")
    while not inbox.payloads:
        await peer.ask("publish", topic="/sensor/in", messages=[{"data": "hello"}])
        await asyncio.sleep(0.01)
    assert inbox.payloads[0] == string("hello")
    await peer.ask("subscribe", topic="/sensor/out", type="std_msgs/msg/String", quality="sensor")
    publisher = await node.advertise("/sensor/out", string_type)
    await until(lambda: publisher.subscriber_count == 1)
    # The peer may not have discovered the subscriber yet, and best-effort messages are not sent again.
    while not (received := await peer.ask("receive", topic="/sensor/out", count=0)):
        publisher.publish_raw([string("back")])
        await asyncio.sleep(0.01)
    assert received[0] == {"data": "back"}


@pytest.mark.parametrize("is_known", [True, False])
async def test_a_subscriber_gets_the_latched_message_of_rclpy(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, is_known: bool
) -> None:
    topic = f"/latched/in/{'known' if is_known else 'unknown'}"
    node, inbox = await join("/board"), Inbox()
    await peer.ask("advertise", topic=topic, type="std_msgs/msg/String", quality="latched")
    await peer.ask("publish", topic=topic, messages=[{"data": "old"}, {"data": "new"}], subscribers=0)
    if is_known:
        while topic not in (await node.snapshot()).topics:
            await asyncio.sleep(0.01)
    await node.subscribe(
        topic, store.registry.message_type("std_msgs/String"), inbox.store, on_connection=inbox.store_header
    )
    await until(lambda: inbox.payloads)
    await peer.ask("publish", topic=topic, messages=[{"data": "newer"}])
    await until(lambda: inbox.payloads[-1] == string("newer"))
    assert inbox.payloads == [string("new"), string("newer")]
    assert [header["latching"] for header in inbox.headers] == ["1"]


async def test_rclpy_gets_the_latched_message(join: JoinGraph, peer: RclpyPeer, store: TypeStore) -> None:
    node = await join("/board")
    string_type = store.registry.message_type("std_msgs/String")
    publisher = await node.advertise("/latched/out", string_type, latch=True)
    publisher.publish_raw([string("old"), string("new")])
    await peer.ask("subscribe", topic="/latched/out", type="std_msgs/msg/String", quality="latched")
    # On a busy machine, the subscriber may connect between the two messages.
    while (await peer.ask("receive", topic="/latched/out", count=1))[-1] != {"data": "new"}:
        await asyncio.sleep(0.05)


async def test_a_connected_subscriber_of_rclpy_gets_all_messages_of_a_latched_topic(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore
) -> None:
    node = await join("/board")
    string_type = store.registry.message_type("std_msgs/String")
    publisher = await node.advertise("/latched/burst", string_type, latch=True)
    await peer.ask("subscribe", topic="/latched/burst", type="std_msgs/msg/String", quality="rosout")
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string(f"{number:03}" + "x" * 20_000) for number in range(100)])
    texts = await peer.ask("receive", topic="/latched/burst", count=100)
    assert [int(each["data"][:3]) for each in texts] == list(range(100))


async def test_a_subscriber_with_an_incompatible_quality_of_service_is_reported(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    node = await join("/board")
    await node.advertise("/fleeting", store.registry.message_type("std_msgs/String"))
    await peer.ask("subscribe", topic="/fleeting", type="std_msgs/msg/String", quality="latched")
    await until(lambda: "a subscriber receives nothing on /fleeting" in caplog.text)
    assert "subscribe with durability volatile" in caplog.text


async def test_endpoints_with_another_type_are_reported(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    node = await join("/board")
    await node.advertise("/heard", store.registry.message_type("std_msgs/String"))
    await node.subscribe("/cmd_vel", store.registry.message_type("geometry_msgs/Twist"), Inbox().store)
    await peer.ask("subscribe", topic="/heard", type="std_msgs/msg/Int32")
    await peer.ask("advertise", topic="/cmd_vel", type="geometry_msgs/msg/TwistStamped")
    await until(
        lambda: (
            f"{PEER_NAME} subscribes to /heard as std_msgs/msg/Int32, but this node uses std_msgs/msg/String"
            in caplog.text
        )
    )
    await until(lambda: f"{PEER_NAME} publishes /cmd_vel as geometry_msgs/msg/TwistStamped" in caplog.text)


async def test_the_type_hash_is_the_official_one(
    join: JoinGraph, context: RclpyContext, peer: RclpyPeer, store: TypeStore
) -> None:
    node = await join("/board")
    for name in MESSAGES:
        message_type = store.registry.message_type(name)
        topic = f"/hash/{name.replace('/', '_')}"
        await node.advertise(topic, message_type)
        # The names of nodes arrive separately, a little later.
        while not (endpoints := await peer.ask("endpoints", topic=topic)) or endpoints[0]["node"] != "board":
            await asyncio.sleep(0.01)
        (endpoint,) = endpoints
        assert endpoint["namespace"] == "/"
        assert endpoint["hash"] == context.types.message(message_type).type_hash
        assert endpoint["type"] == ros2_name(name)


async def test_logs_reach_rosout(join: JoinGraph, peer: RclpyPeer) -> None:
    await peer.ask("subscribe", topic="/rosout", type="rcl_interfaces/msg/Log", quality="rosout")
    node = await join("board", namespace="/robot")
    for level in Level:
        node.log(level, f"of level {level.name}")
    while True:
        logs = await peer.ask("receive", topic="/rosout", count=len(Level))
        node_logs = [log for log in logs if log["name"] == "robot.board"]
        if len(node_logs) == len(Level):
            break
        await asyncio.sleep(0.01)
    assert [(log["level"], log["msg"]) for log in node_logs] == [
        (10, "of level DEBUG"),
        (20, "of level INFO"),
        (30, "of level WARN"),
        (40, "of level ERROR"),
        (50, "of level FATAL"),
    ]


async def test_a_type_that_is_not_installed_is_refused(join: JoinGraph) -> None:
    node = await join("/board")
    custom_type = MessageType("my_robot_msgs/Feather", "0" * 32, "float32 weight\n")
    for attempt in (
        node.advertise("/feather", custom_type),
        node.subscribe("/feather", custom_type, Inbox().store),
    ):
        with pytest.raises(UnknownTypeError, match="the package my_robot_msgs is not installed") as caught:
            await attempt
        assert "\n" not in str(caught.value)


def is_stopped(pid: int) -> bool:
    """Return whether all threads of a process are stopped."""
    threads = Path(f"/proc/{pid}/task").glob("*/stat")
    return all(each.read_text().rpartition(") ")[2].startswith("T") for each in threads)


async def test_a_publisher_waits_for_subscribers_that_do_not_know_it_yet(
    join: JoinGraph, peer: RclpyPeer
) -> None:
    """A publisher may discover a subscriber that has not discovered it yet, and drops its messages."""
    node = await join("/hasty")
    await peer.ask("subscribe", topic="/hasty_text", type="std_msgs/msg/String")
    await wait_for_snapshot(node, lambda seen: "/hasty_text" in seen.topics, 60)
    os.kill(peer.pid, signal.SIGSTOP)
    try:
        # On a busy machine, its threads may continue for a short time, and discover the publisher.
        await until(lambda: is_stopped(peer.pid))
        publisher = await node.advertise("/hasty_text", STRING)
        await until(lambda: publisher.subscriber_count)
        publisher.publish_raw([string("hello")])
        drained = asyncio.ensure_future(publisher.drained(60))
        await asyncio.wait({drained}, timeout=0.5)
        assert not drained.done()
    finally:
        os.kill(peer.pid, signal.SIGCONT)
    await drained
    # The program may not have received an acknowledged message: its middleware may drop messages of closed
    # publishers.
    assert await peer.ask("receive", topic="/hasty_text", count=1) == [{"data": "hello"}]
    await publisher.close()
