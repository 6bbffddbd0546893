"""Replays recorded sessions of established boards: ROS gets exactly their messages.

The expected messages are read here with a decoder written from the wire's description, without the tested
packages.
"""

from __future__ import annotations

import asyncio
import struct
from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple

import pytest

from rostether.bridge.board_node import BoardNode
from rostether.bridge.session import Session
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from unit.bridge.doubles import FakeTransport
from unit.bridge.nodes import STORE, World
from unit.bridge.virtual_time import run
from vectors.captures import Capture, load, names

ANNOUNCEMENT_IDS = range(6)
LOG_ID = 7
# Types of the captures that begin with a Header: the bridge counts their messages in Header.seq, from 1.
COUNTED_TYPES = {"sensor_msgs/Imu", "sensor_msgs/Range"}
LOG_LEVELS = [Level.DEBUG, Level.INFO, Level.WARN, Level.ERROR, Level.FATAL]


class Frame(NamedTuple):
    topic_id: int
    payload: bytes


def frames(data: bytes, version: int) -> Iterator[Frame]:
    """Yield every valid frame; if none begins at a byte, try the next byte."""
    at = 0
    while at + 7 < len(data):
        frame = _frame_at(data, at, version)
        if frame is None:
            at += 1
        else:
            yield frame
            at += len(frame.payload) + (8 if version == 2 else 7)


def _frame_at(data: bytes, at: int, version: int) -> Frame | None:
    if version == 2:
        sync, size, size_check, topic_id = struct.unpack_from("<HHBH", data, at)
        payload = data[at + 7 : at + 7 + size]
        end = at + 7 + size
        sound = sync == 0xFEFF and (sum(struct.pack("<H", size)) + size_check) % 256 == 255
        summed = struct.pack("<H", topic_id) + payload
    else:
        sync, topic_id, size = struct.unpack_from("<HHH", data, at)
        payload = data[at + 6 : at + 6 + size]
        end = at + 6 + size
        sound = sync == 0xFFFF
        summed = struct.pack("<HH", topic_id, size) + payload
    if not sound or end >= len(data) or (sum(summed) + data[end]) % 256 != 255:
        return None
    return Frame(topic_id, payload)


class Held(NamedTuple):
    """The content of a capture: messages by topic, log lines."""

    messages: dict[str, list[bytes]]
    logs: list[tuple[Level, str]]


def held_by(capture: Capture) -> Held:
    messages: dict[str, list[bytes]] = defaultdict(list)
    logs: list[tuple[Level, str]] = []
    announced: set[int] = set()
    for frame in frames(b"".join(chunk.data for chunk in capture.of_device()), capture.version):
        topic = capture.topics.get(frame.topic_id)
        if frame.topic_id in ANNOUNCEMENT_IDS and len(frame.payload) > 2:
            announced.add(int.from_bytes(frame.payload[:2], "little"))
        elif frame.topic_id == LOG_ID:
            logs.append((LOG_LEVELS[frame.payload[0]], frame.payload[5:].decode()))
        elif topic is not None and topic.kind == "publisher" and frame.topic_id in announced:
            published = messages["/" + topic.name.lstrip("/")]
            count = struct.pack("<I", len(published) + 1) if topic.type in COUNTED_TYPES else b""
            published.append(count + frame.payload[len(count) :])
    return Held(dict(messages), logs)


async def replay(capture: Capture, store: TypeStore = STORE) -> tuple[dict[str, list[bytes]], World]:
    """Replay the board's bytes to a session at their times; return the messages that ROS got."""
    world = await World().open()
    received = {
        "/" + topic.name.lstrip("/"): await world.listen(topic.name, topic.type)
        for topic in capture.topics.values()
        if topic.kind == "publisher"
    }
    loop = asyncio.get_running_loop()
    node = BoardNode(world.board, store, world.reporter, loop.time)
    session = Session(FakeTransport(can_pause=False), node, baud=57600)
    session.start()
    began_s = loop.time()
    for chunk in capture.of_device():
        await asyncio.sleep(began_s + chunk.time_s - loop.time())
        session.data_received(chunk.data)
    await asyncio.sleep(2.0)
    session.connection_lost(None)
    await node.close()
    return {topic: messages for topic, messages in received.items() if messages}, world


@pytest.mark.parametrize("name", names())
def test_ros_gets_exactly_what_the_capture_holds(name: str) -> None:
    capture = load(name)
    held = held_by(capture)
    published, world = run(replay(capture))
    assert published == held.messages
    logs = [(log.level, log.text) for log in world.network.logs]
    assert [log for log in logs if log in held.logs] == held.logs
    assert not world.reporter.having("session failed")
    assert len(world.reporter.lines) < 20 + len(held.logs)


@pytest.mark.parametrize("name", names())
def test_the_capture_holds_something(name: str) -> None:
    """The decoder above finds the messages that the capture's description names."""
    capture = load(name)
    held = held_by(capture)
    publishers = {
        "/" + topic.name.lstrip("/") for topic in capture.topics.values() if topic.kind == "publisher"
    }
    assert set(held.messages) == publishers


def test_a_topic_of_an_unknown_package_is_named() -> None:
    store = TypeStore(Registry(bundled=False))
    _, world = run(replay(load("mearm"), store))
    (reported,) = world.reporter.having("servo_angles")
    assert "mearm_model" in reported
    assert "--msg-path" in reported


def test_a_boards_calls_reach_the_service() -> None:
    capture = load("serviceclient")
    calls: list[bytes] = []

    async def replay_with_service() -> None:
        world = await World().open()

        async def answer(request: bytes) -> bytes:
            calls.append(request)
            return struct.pack("<I", 6) + b"answer"

        await world.peer.advertise_service(
            "/test_srv", STORE.registry.service_type("rosserial_arduino/Test"), answer
        )
        loop = asyncio.get_running_loop()
        node = BoardNode(world.board, STORE, world.reporter, loop.time)
        transport = FakeTransport()
        session = Session(transport, node)
        session.start()
        for chunk in capture.of_device():
            await asyncio.sleep(0.01)
            session.data_received(chunk.data)
        await asyncio.sleep(1.0)
        session.connection_lost(None)
        await node.close()
        sent = [frame.payload for frame in frames(transport.written, 2) if frame.topic_id == 100]
        assert sent == [struct.pack("<I", 6) + b"answer"] * len(calls)

    run(replay_with_service())
    data = b"".join(chunk.data for chunk in capture.of_device())
    assert calls == [frame.payload for frame in frames(data, 2) if frame.topic_id == 125]
    assert len(calls) > 50
