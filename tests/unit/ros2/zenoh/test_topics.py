"""Topics with peers of other programs: plain zenoh, other types, invalid bytes."""

from __future__ import annotations

import asyncio
import logging
import struct
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
import zenoh

from contract.graphs import BOOL, STRING, Inbox, string
from contract.zenoh_graphs import open_router, open_session, ros2_types
from loop_watch import CallbackWatch
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.ros2.endpoint_info import find_distribution
from rostether.ros2.zenoh.attachment import parse_attachment
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh.tokens import data_key
from waiting import until

FLOATS = ros2_types().registry.message_type("std_msgs/Float32MultiArray")
IMU = ros2_types().registry.message_type("sensor_msgs/Imu")
CDR_HELLO = b"\0\1\0\0\x06\0\0\0hello\0"


@pytest_asyncio.fixture
async def session() -> AsyncIterator[ZenohSession]:
    session, _ = await open_router()
    yield session
    await session.close()


def key_of(topic: str, message_type: MessageType = STRING, type_hash: str = "") -> str:
    support = ros2_types().message(message_type)
    package, _, name = support.name.split("/")
    return data_key(0, topic, f"{package}::msg::dds_::{name}_", type_hash or support.type_hash)


async def test_samples_have_cdr_and_an_increasing_sequence(session: ZenohSession) -> None:
    samples: list[tuple[bytes, bytes]] = []

    def take(sample: zenoh.Sample) -> None:
        assert sample.attachment is not None
        samples.append((sample.payload.to_bytes(), sample.attachment.to_bytes()))

    session.zenoh.declare_subscriber(key_of("/chat"), take)
    node = await session.join("talker")
    publisher = await node.advertise("/chat", STRING)
    # There are no tokens; only zenoh knows the subscriber.
    publisher.publish_raw([string("hello"), string("hello")])
    await until(lambda: len(samples) == 2)
    assert [payload for payload, _ in samples] == [CDR_HELLO] * 2
    attachments = [parse_attachment(data) for _, data in samples]
    assert [each.sequence for each in attachments if each] == [1, 2]
    assert len({each.gid for each in attachments if each}) == 1


async def test_messages_of_a_publisher_without_a_token_are_received(session: ZenohSession) -> None:
    node, typed, anything = await session.join("listener"), Inbox(), Inbox()
    await node.subscribe("/chat", STRING, typed.store, on_connection=typed.store_header)
    await node.subscribe("/chat", ANY_MESSAGE, anything.store, on_connection=anything.store_header)
    session.zenoh.put(key_of("/chat"), CDR_HELLO)
    await until(lambda: typed.payloads and anything.payloads)
    assert typed.payloads == anything.payloads == [string("hello")]
    # A subscriber of any type learns the type of the topic.
    assert typed.headers == []
    assert anything.headers[0]["type"] == "std_msgs/String"


async def test_invalid_cdr_is_reported_once(session: ZenohSession, caplog: pytest.LogCaptureFixture) -> None:
    node, inbox = await session.join("listener"), Inbox()
    await node.subscribe("/chat", STRING, inbox.store)
    for payload in (b"", b"\0\1\0\0\xff\xff\xff\x7f", b"x" * 1000, CDR_HELLO):
        session.zenoh.put(key_of("/chat"), payload)
    session.zenoh.delete(key_of("/chat"))
    session.zenoh.put(key_of("/chat"), CDR_HELLO)
    await until(lambda: len(inbox.payloads) == 2)
    assert inbox.payloads == [string("hello")] * 2
    assert caplog.text.count("a message does not fit its type") == 1


async def test_lost_messages_are_reported_once(
    session: ZenohSession, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("rostether.ros2.zenoh.subscription.DEFAULT_QUEUE_BYTES", 3 * len(CDR_HELLO))
    node, inbox = await session.join("listener"), Inbox()
    subscriber = await node.subscribe("/chat", STRING, inbox.store)
    for _ in range(2):
        inbox.payloads.clear()
        subscriber.pause()
        for _ in range(5):
            session.zenoh.put(key_of("/chat"), CDR_HELLO)
        subscriber.resume()
        await until(lambda: len(inbox.payloads) == 3)
    assert caplog.text.count("messages of /chat arrive faster than this node handles them") == 1


async def test_large_messages_are_converted_outside_the_event_loop(
    session: ZenohSession, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    node, inbox, any_inbox = await session.join("node"), Inbox(), Inbox()
    subscriber = await node.subscribe("/many", FLOATS, inbox.store)
    await node.subscribe("/many", ANY_MESSAGE, any_inbox.store)
    await (await session.join("talker")).advertise("/many", FLOATS)
    await until(lambda: subscriber.publisher_count)
    watch = CallbackWatch(monkeypatch)
    # Each big-endian number takes a microsecond.
    head = b"\0\0\0\0" + bytes(4) + bytes(4) + struct.pack(">I", 150_000)
    for data in (head + bytes(600_000), head + bytes(600_000 - 1)):
        await asyncio.to_thread(session.zenoh.put, key_of("/many", FLOATS), data)
    await until(lambda: any_inbox.payloads and "a message does not fit its type" in caplog.text)
    watch.check("a large message")
    assert [len(each) for each in inbox.payloads] == [600_012]


async def test_payloads_that_do_not_fit_are_not_sent(
    session: ZenohSession, caplog: pytest.LogCaptureFixture
) -> None:
    node, inbox = await session.join("node"), Inbox()
    publisher = await node.advertise("/chat", STRING)
    await node.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    assert publisher.publish_raw([b"\xff\xff\xff\xff", string("good"), b""])
    await until(lambda: inbox.payloads)
    assert inbox.payloads == [string("good")]
    assert publisher.dropped_count == 2
    assert caplog.text.count("cannot be converted for ROS 2:") == 1


async def test_endpoints_with_different_types_are_reported(
    session: ZenohSession, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    talker, listener = await session.join("talker"), await session.join("listener")
    await talker.advertise("/chat", STRING)
    await listener.subscribe("/chat", BOOL, Inbox().store)
    assert (
        "/talker publishes /chat as std_msgs/msg/String, but this node uses std_msgs/msg/Bool" in caplog.text
    )
    assert "/listener subscribes to /chat as std_msgs/msg/Bool" in caplog.text
    await (await session.join("another")).advertise("/other", STRING)
    assert caplog.text.count("they do not connect;") == 2


async def test_another_definition_of_a_type_is_reported(
    session: ZenohSession, caplog: pytest.LogCaptureFixture
) -> None:
    node, inbox = await session.join("listener"), Inbox()
    await node.subscribe("/chat", STRING, inbox.store)
    await node.subscribe("/chat", ANY_MESSAGE, inbox.store)
    foreign = "RIHS01_" + "1" * 64
    token = f"@ros2_lv/0/abc/0/1/MP/%/%/far/%chat/std_msgs::msg::dds_::String_/{foreign}/::,10:,:,:,,"
    declared = session.zenoh.liveliness().declare_token(token)
    await until(lambda: "another definition of std_msgs/msg/String" in caplog.text)
    await until(lambda: "is not the known one" in caplog.text)
    session.zenoh.put(key_of("/chat", type_hash=foreign), CDR_HELLO)
    session.zenoh.put(key_of("/chat"), CDR_HELLO)
    await until(lambda: len(inbox.payloads) == 2)
    declared.undeclare()


async def test_an_unknown_type_is_reported_once(
    session: ZenohSession, caplog: pytest.LogCaptureFixture
) -> None:
    node, inbox = await session.join("listener"), Inbox()
    await node.subscribe("/chat", ANY_MESSAGE, inbox.store)
    for name in ("nowhere_msgs::msg::dds_::Nothing_", "nowhere_msgs::msg::dds_::Nothing_", "nonsense"):
        session.zenoh.put(data_key(0, "/chat", name, "RIHS01_00"), CDR_HELLO)
    session.zenoh.put(key_of("/chat"), CDR_HELLO)
    await until(lambda: inbox.payloads)
    assert inbox.payloads == [string("hello")]
    assert caplog.text.count("cannot receive /chat") == 2


async def test_a_node_can_skip_its_own_messages(session: ZenohSession) -> None:
    node, other, inbox = await session.join("node"), await session.join("other"), Inbox()
    own, foreign = await node.advertise("/chat", STRING), await other.advertise("/chat", STRING)
    await node.subscribe("/chat", STRING, inbox.store, skip_own=True)
    await until(lambda: own.subscriber_count == foreign.subscriber_count == 1)
    own.publish_raw([string("own")])
    foreign.publish_raw([string("foreign")])
    await until(lambda: inbox.payloads)
    assert inbox.payloads == [string("foreign")]


async def test_a_handle_that_latches_makes_its_topic_latch(session: ZenohSession) -> None:
    talker, listener, inbox = await session.join("talker"), await session.join("listener"), Inbox()
    plain = await talker.advertise("/map", STRING)
    latching = await talker.advertise("/map", STRING, latch=True)
    latching.publish_raw([string("kept")])
    await listener.subscribe("/map", STRING, inbox.store, on_connection=inbox.store_header)
    await until(lambda: inbox.payloads)
    assert inbox.headers[0]["latching"] == "1"
    assert plain.subscriber_count == 1


async def test_a_header_loses_only_its_sequence(session: ZenohSession) -> None:
    node, inbox = await session.join("node"), Inbox()
    publisher = await node.advertise("/imu", IMU)
    await node.subscribe("/imu", IMU, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    payload = (7).to_bytes(4, "little") + bytes(range(12)) + bytes(296)
    payload = payload[:12] + bytes(4) + payload[16:]  # An empty frame_id.
    publisher.publish_raw([payload])
    await until(lambda: inbox.payloads)
    assert inbox.payloads == [bytes(4) + payload[4:]]


async def test_a_link_with_room_pauses_no_publisher(session: ZenohSession) -> None:
    node = await session.join("node")
    publisher = await node.advertise("/chat", STRING)
    assert publisher.publish_raw([string("without a subscriber")] * 10_000)
    await publisher.drained(0.0)
    assert publisher.dropped_count == 0


async def test_a_full_link_pauses_the_publisher_and_then_drops(monkeypatch: pytest.MonkeyPatch) -> None:
    here, port = await open_router()
    there = await open_session(port, is_router=False)
    talker, listener, inbox = await here.join("talker"), await there.join("listener"), Inbox()
    publisher = await talker.advertise("/chat", STRING, queue_bytes=1 << 20)
    await listener.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    # Every put counts as one that had to wait.
    monkeypatch.setattr("rostether.ros2.zenoh.publication.STALL_NS", -1)
    sent = [string(f"{number:04}".ljust(4000)) for number in range(100)]
    assert not publisher.publish_raw(sent)
    monkeypatch.undo()
    await publisher.drained(10.0)
    assert publisher.publish_raw([])
    await until(lambda: len(inbox.payloads) == 100)
    assert inbox.payloads == sent
    monkeypatch.setattr("rostether.ros2.zenoh.publication.STALL_NS", -1)
    publisher.publish_raw(sent * 10)
    assert publisher.dropped_count > 700
    monkeypatch.undo()
    await publisher.close()
    # On closing, the publisher puts its waiting messages.
    await until(lambda: inbox.payloads[-1] == sent[-1] and len(inbox.payloads) > 300)
    await there.close()
    await here.close()


async def test_nodes_without_hashes_are_from_humble(session: ZenohSession) -> None:
    node = await session.join("/watcher")
    await node.advertise("/chat", STRING)
    assert await find_distribution(node, {"ROS_DISTRO": "noetic"}) == "jazzy"
    token = "@ros2_lv/0/1f/0/1/MP/%/%/talker/"
    token += "%chat/std_msgs::msg::dds_::String_/TypeHashNotSupported/::,10:,:,:,,"
    session.graph.apply_tokens([(token, True)])
    assert await find_distribution(node, {"ROS_DISTRO": "noetic"}) == "humble"
    assert await find_distribution(node, {"ROS_DISTRO": "iron"}) == "iron"
    session.graph.apply_tokens([(token, False)])
