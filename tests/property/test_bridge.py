"""Faults of a line never stop the bridge, and ROS gets no message that the board did not send."""

from __future__ import annotations

import asyncio
import random
import struct

from hypothesis import given, settings
from hypothesis import strategies as st

from effort import effort
from property.test_rosserial_frames import split
from rostether.bridge.board_node import BoardNode
from rostether.bridge.session import Session
from rostether.device.device import Device
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.transports.memory import Direction, memory_pair
from unit.bridge.doubles import FakeTransport
from unit.bridge.nodes import STORE, World, text, topic_info
from unit.bridge.virtual_time import run

ANNOUNCED = (
    encode_frame(ids.TIME, bytes(8))
    + encode_frame(ids.PUBLISHER, topic_info("chatter", topic_id=125).encode())
    + encode_frame(ids.PUBLISHER, topic_info("level", "std_msgs/UInt16", topic_id=126).encode())
    + encode_frame(ids.SUBSCRIBER, topic_info("led", topic_id=100).encode())
)


async def start_session(world: World) -> Session:
    loop = asyncio.get_running_loop()
    session = Session(FakeTransport(), BoardNode(world.board, STORE, world.reporter, loop.time))
    session.start()
    return session


@given(st.lists(st.text(max_size=40), max_size=20), st.lists(st.integers(0, 1 << 16), max_size=30))
@settings(deadline=None, max_examples=effort(20, 60))
def test_any_chunking_gives_the_same_messages(strings: list[str], cuts: list[int]) -> None:
    async def scenario() -> list[bytes]:
        world = await World().open()
        received = await world.listen("/chatter")
        session = await start_session(world)
        data = ANNOUNCED + b"".join(encode_frame(125, text(word)) for word in strings)
        for chunk in split(data, cuts):
            session.data_received(chunk)
            await asyncio.sleep(0)
        await asyncio.sleep(0.01)
        session.connection_lost(None)
        return received

    assert run(scenario()) == [text(word) for word in strings]


@given(st.lists(st.binary(max_size=200), max_size=20))
@settings(deadline=None, max_examples=effort(20, 60))
def test_garbage_does_not_stop_the_bridge_and_is_reported_briefly(garbage: list[bytes]) -> None:
    async def scenario() -> tuple[list[bytes], World]:
        world = await World().open()
        received = await world.listen("/chatter")
        session = await start_session(world)
        session.data_received(ANNOUNCED)
        await asyncio.sleep(1.0)
        for piece in garbage:
            session.data_received(piece)
            await asyncio.sleep(0.01)
        # Silence ends a frame that garbage has begun; within seconds a valid frame arrives again.
        await asyncio.sleep(3.0)
        session.data_received(encode_frame(125, text("good")))
        await asyncio.sleep(3.0)
        session.connection_lost(None)
        return received, world

    received, world = run(scenario())
    assert received[-1:] == [text("good")]
    assert not world.reporter.having("session failed")
    assert len(world.reporter.lines) < 15 + len(garbage)


@given(
    st.lists(
        st.tuples(
            st.sampled_from([100, 111, 120, 125, 126, 127, 6, 7, 9, 10, 11, 200]), st.binary(max_size=60)
        ),
        max_size=60,
    )
)
@settings(deadline=None, max_examples=effort(20, 60))
def test_malformed_messages_never_reach_ros(frames: list[tuple[int, bytes]]) -> None:
    async def scenario() -> tuple[list[bytes], list[bytes]]:
        world = await World().open()
        strings = await world.listen("/chatter")
        levels = await world.listen("/level", "std_msgs/UInt16")
        session = await start_session(world)
        session.data_received(ANNOUNCED)
        session.data_received(b"".join(encode_frame(*frame) for frame in frames))
        await asyncio.sleep(2.0)
        session.connection_lost(None)
        return strings, levels

    strings, levels = run(scenario())
    string, level = STORE.layout("std_msgs/String"), STORE.layout("std_msgs/UInt16")
    assert strings == [payload for topic_id, payload in frames if topic_id == 125 and string.accepts(payload)]
    assert levels == [payload for topic_id, payload in frames if topic_id == 126 and level.accepts(payload)]


@given(st.integers(0, 1 << 32))
@settings(deadline=None, max_examples=effort(8, 15))
def test_all_endpoints_connect_on_a_line_that_damages_one_write_in_twenty(seed: int) -> None:
    """25 publishers, 25 subscribers and a service: all in the graph within 2 s of link time."""
    rng = random.Random(seed)

    def damage(chunk: bytes, direction: Direction) -> bytes:
        # Frame by frame, as on a line; a chunk of the device may hold many.
        pieces = []
        offset = 0
        while offset < len(chunk):
            size = 8
            if chunk[offset : offset + 2] == b"\xff\xfe" and len(chunk) - offset >= 8:
                size += struct.unpack_from("<H", chunk, offset + 2)[0]
            piece = bytearray(chunk[offset : offset + size])
            offset += size
            if rng.random() < 0.05:
                if rng.random() < 0.5:
                    continue
                piece[rng.randrange(len(piece))] ^= rng.randrange(1, 256)
            pieces.append(bytes(piece))
        return b"".join(pieces)

    async def scenario() -> None:
        world = await World().open()
        loop = asyncio.get_running_loop()
        node = BoardNode(world.board, STORE, world.reporter, loop.time)
        host_side, device_side = memory_pair(damage)
        session = Session(host_side, node)
        async with Device(device_side, store=STORE, clock=loop.time) as device:
            for number in range(25):
                device.publisher(f"out{number}", "std_msgs/String")
                device.subscriber(f"in{number}", "std_msgs/UInt16", lambda _: None)
            device.service_server("switch", "std_srvs/SetBool", lambda _: {})
            session.start()
            began_s = loop.time()
            while sum(1 for _ in node.endpoints) < 51 or not session.link.is_settled:
                await asyncio.sleep(0.01)
                assert loop.time() - began_s < 2.0
            await session.stop()

    run(scenario())
