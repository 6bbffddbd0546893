"""A publication, tested with raw sockets."""

from __future__ import annotations

import asyncio
import re
import socket
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from rostether.errors import TypeMismatchError
from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.ros1.node.publication import Publication, Publisher
from rostether.ros1.node.subscriber_connection import SLOW_REPORT_INTERVAL_S
from rostether.ros1.node.tcpros_listener import TcprosListener
from rostether.tcpros.message_framing import encode_messages
from unit.ros1.node.raw_peers import STRING, RawPeer, until

BOOL = MessageType("std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a", "bool data\n")


class Stage:
    """One publication behind a listener."""

    def __init__(self, *, latch: bool = False, queue_bytes: int | None = None) -> None:
        self.reports: list[tuple[Level, str]] = []
        self.topic = Publication(
            "/chat",
            STRING,
            node_name="/talker",
            report=self.report,
            latch=latch,
            queue_bytes=queue_bytes,
        )
        self.listener = TcprosListener(self.topic.accept, self.topic.accept, self.report)

    def report(self, level: Level, text: str) -> None:
        self.reports.append((level, text))

    async def __aenter__(self) -> Stage:
        await self.listener.start(["127.0.0.1"])
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.topic.close()
        await self.listener.close()


@pytest_asyncio.fixture
async def stage() -> AsyncIterator[Stage]:
    async with Stage() as stage:
        yield stage


@pytest.mark.parametrize("md5sum", [STRING.md5sum, "*"])
async def test_a_subscriber_is_answered_with_everything_about_the_topic(stage: Stage, md5sum: str) -> None:
    async with RawPeer.subscribing(stage.listener.port, "/chat", md5sum=md5sum) as peer:
        assert await peer.read_header() == {
            "callerid": "/talker",
            "latching": "0",
            "md5sum": STRING.md5sum,
            "message_definition": STRING.definition,
            "topic": "/chat",
            "type": STRING.name,
        }
        stage.topic.publish([b"one", b"two"])
        assert [await peer.read_message(), await peer.read_message()] == [b"one", b"two"]
        (connection,) = stage.topic.connections
        assert connection.record.peer == "/raw"
        assert (connection.record.message_count, connection.record.byte_count) == (2, 14)
    await until(lambda: not stage.topic.connections)


async def test_another_type_is_refused_with_a_reason_and_one_warning(stage: Stage) -> None:
    async with RawPeer.subscribing(stage.listener.port, "/chat", md5sum=BOOL.md5sum, type=BOOL.name) as peer:
        assert (await peer.read_header())["error"] == (
            "topic types do not match: [std_msgs/Bool] vs. [std_msgs/String]"
        )
        assert await peer.is_hung_up()
    assert [level for level, _ in stage.reports] == [Level.WARN]
    assert not stage.topic.connections


async def test_a_late_subscriber_gets_the_latched_message_after_the_header() -> None:
    async with Stage(latch=True) as stage:
        stage.topic.publish([b"old", b"new"])
        async with RawPeer.subscribing(stage.listener.port, "/chat") as peer:
            assert (await peer.read_header())["latching"] == "1"
            assert await peer.read_message() == b"new"
            stage.topic.publish([b"next"])
            assert await peer.read_message() == b"next"


async def test_peers_that_disconnect_at_once_affect_no_other(stage: Stage) -> None:
    for _ in range(20):
        async with RawPeer.subscribing(stage.listener.port, "/chat"):
            pass
        await (await RawPeer.connect(stage.listener.port)).close()
    async with RawPeer.subscribing(stage.listener.port, "/chat") as peer:
        await peer.read_header()
        await until(lambda: len(stage.topic.connections) == 1)
        stage.topic.publish([b"hello"])
        assert await peer.read_message() == b"hello"
    assert stage.reports == []


async def test_data_from_a_subscriber_is_ignored(stage: Stage) -> None:
    async with RawPeer.subscribing(stage.listener.port, "/chat") as peer:
        await peer.read_header()
        peer.writer.write(b"GET / HTTP/1.1\r\n\r\n" * 100)
        stage.topic.publish([b"hello"])
        assert await peer.read_message() == b"hello"


async def test_small_messages_are_never_held_back(stage: Stage) -> None:
    async with RawPeer.subscribing(stage.listener.port, "/chat", tcp_nodelay="1") as peer:
        await peer.read_header()
        await until(lambda: stage.topic.connections)
        transport = stage.topic.connections[0]._transport
        opened = transport.get_extra_info("socket")
        assert opened.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        assert opened.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)


@pytest.mark.parametrize("per_batch", [1, 7, 50])
async def test_a_peer_that_hangs_gets_whole_messages_and_loses_the_oldest(per_batch: int) -> None:
    async with (
        Stage(queue_bytes=100_000) as stage,
        RawPeer.subscribing(stage.listener.port, "/chat") as peer,
    ):
        await peer.read_header()
        await until(lambda: stage.topic.connections)
        sent = 0
        # Messages of many lengths, so that a cut in the wrong place would be seen.
        while stage.topic.dropped_count < 500:
            batch = [b"%d:" % number + bytes(number % 3000) for number in range(sent, sent + per_batch)]
            stage.topic.publish(batch)
            sent += per_batch
        (connection,) = stage.topic.connections
        assert connection._queued_bytes <= 100_000
        assert sum(len(data) for data, _ in connection._queue) == connection._queued_bytes
        received: list[int] = []
        while not received or received[-1] != sent - 1:
            message = await peer.read_message()
            number = int(message.partition(b":")[0])
            assert len(message) == len(b"%d:" % number) + number % 3000
            received.append(number)
        assert len(received) == sent - stage.topic.dropped_count
        assert received == sorted(received)
        # The newest messages that fit in the queue are all there.
        assert received[-20:] == list(range(sent - 20, sent))
        assert connection.dropped_count == stage.topic.dropped_count
        assert len(stage.reports) == 1
        assert "/raw is too slow for /chat; dropping" in stage.reports[0][1]
        assert re.search(r", [1-9]\d* messages? dropped so far\)$", stage.reports[0][1])
        # A new loss within the report interval adds no report; a later one does.
        for is_soon in (True, False):
            await until(lambda: connection._accepts_more)
            if not is_soon:
                connection._may_report_s -= SLOW_REPORT_INTERVAL_S
            before = stage.topic.dropped_count
            while stage.topic.dropped_count == before:
                stage.topic.publish([bytes(1000)] * 10)
            assert len(stage.reports) == (1 if is_soon else 2)
            while is_soon and connection._queue:
                await peer.read_message()


async def test_closing_sends_what_waits(stage: Stage) -> None:
    async with RawPeer.subscribing(stage.listener.port, "/chat") as peer:
        await peer.read_header()
        await until(lambda: stage.topic.connections)
        while stage.topic.publish([bytes(100_000)]):
            pass
        stage.topic.publish([b"the end"])
        closing = asyncio.ensure_future(stage.topic.close())
        message = b""
        while message != b"the end":
            message = await peer.read_message()
        assert await peer.is_hung_up()
        await closing
    assert not stage.topic.connections


async def test_closing_does_not_wait_for_a_peer_that_hangs(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.ros1.node.subscriber_connection.CLOSE_GRACE_S", 0.05)
    async with RawPeer.subscribing(stage.listener.port, "/chat") as peer:
        await peer.read_header()
        await until(lambda: stage.topic.connections)
        for _ in range(100):
            stage.topic.publish([bytes(100_000)])
        await asyncio.wait_for(stage.topic.close(), 60)
        assert not stage.topic.connections
        peer.writer.transport.abort()


async def test_two_handles_share_a_publication(stage: Stage) -> None:
    released: list[int] = []

    async def release(publication: Publication) -> None:
        released.append(publication.handle_count)

    first, second = Publisher(stage.topic, release), Publisher(stage.topic, release)
    stage.topic.share(STRING, latch=False)
    with pytest.raises(TypeMismatchError, match="publishes /chat as std_msgs/String,"):
        stage.topic.share(BOOL, latch=False)
    await first.close()
    await first.close()
    assert first.publish_raw([b"unheard"])
    assert released == []
    await second.close()
    assert released == [0]


async def test_one_encoding_serves_all_subscribers(stage: Stage) -> None:
    async with (
        RawPeer.subscribing(stage.listener.port, "/chat") as first,
        RawPeer.subscribing(stage.listener.port, "/chat") as second,
    ):
        await until(lambda: len(stage.topic.connections) == 2)
        stage.topic.publish([b"a", b"bb"])
        wire = encode_messages([b"a", b"bb"])
        for peer in (first, second):
            await peer.read_header()
            assert await peer.reader.readexactly(len(wire)) == wire
        assert stage.topic.byte_count == len(wire)
