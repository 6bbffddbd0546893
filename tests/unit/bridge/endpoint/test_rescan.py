from __future__ import annotations

import asyncio

import pytest

from rostether.bridge.board_node import BoardNode
from rostether.bridge.session import MAX_RESCAN_DEPTH, Session
from rostether.bridge.settings import BridgeSettings
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import HostEvent, MessagesReceived
from rostether.rosserial.frame import encode_frame
from rostether.transports.memory import memory_pair
from unit.bridge.nodes import STORE, World, text, topic_info
from unit.bridge.raw_board import RawBoard
from waiting import until


def lucky_header(topic_id: int, following: bytes) -> bytes:
    """A header whose frame contains the following bytes and by chance has a correct checksum, if there is
    one.
    """
    for size in range(200, len(following)):
        candidate = encode_frame(topic_id, following[:size])
        if candidate[-1] == following[size]:
            return candidate[:7]
    return b""


async def test_nested_searches_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    world = await World().open()
    node = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time, BridgeSettings())
    ours, _ = memory_pair()
    session = Session(ours, node)
    looks = 0

    def rescan(payload: bytes, now_s: float) -> list[HostEvent]:
        nonlocal looks
        looks += 1
        return [MessagesReceived(125, [payload])]

    monkeypatch.setattr(session.link, "rescan", rescan)
    session.receivers[125] = lambda payloads: session.rescan(payloads[0])
    session.rescan(b"")
    assert looks == MAX_RESCAN_DEPTH
    session.rescan(b"")
    assert looks == 2 * MAX_RESCAN_DEPTH
    await session.stop()
    await node.close()


async def test_headers_of_noise_between_messages_cost_few_messages() -> None:
    world = await World().open()
    received = await world.listen("/chatter")
    loop = asyncio.get_running_loop()
    node = BoardNode(world.board, STORE, world.reporter, loop.time, BridgeSettings())
    ours, theirs = memory_pair()
    RawBoard(theirs, (ids.PUBLISHER, topic_info("chatter", topic_id=125, buffer_size=2048)))
    session = Session(ours, node)
    session.start()
    try:
        await until(lambda: session.link.is_settled, "the negotiation")
        sent = [text(f"message {number}") for number in range(3000)]
        frames = [encode_frame(125, payload) for payload in sent]
        stream = bytearray()
        for number, frame in enumerate(frames):
            if number % 100 == 0 and number < 2900:
                stream += lucky_header(125, b"".join(frames[number : number + 85]))
            stream += frame
        statistics = session.link.statistics
        announced = statistics.frames_received
        for start in range(0, len(stream), 16384):
            session.data_received(bytes(stream[start : start + 16384]))
        await until(lambda: sent[-1] in received, "the last message")
        misfits = statistics.frames_received - announced - len(received)
        assert misfits > 15
        assert len(sent) - len(received) <= misfits
        assert received == [payload for payload in sent if payload in set(received)]
    finally:
        await session.stop()
        await node.close()
