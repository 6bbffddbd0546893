"""A subscription and its publishers, some of which are faulty."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import struct
from collections.abc import AsyncIterator, Mapping

import pytest

from contract.graphs import Inbox
from rostether.graph.ports import Level
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.ros1.node import publisher_connection
from rostether.ros1.node.publisher_connection import TURN_MESSAGES
from rostether.ros1.node.subscription import Subscription
from rostether.tcpros.message_framing import encode_messages
from unit.ros1.node.raw_peers import STRING, FakePublisher, until


class Stage:
    """One subscription with what it reports."""

    def __init__(self, message_type: MessageType = STRING, *, tcp_nodelay: bool = True) -> None:
        self.inbox = Inbox()
        self.reports: list[tuple[Level, str]] = []
        self.closed: list[Subscription] = []
        self.topic = Subscription(
            "/chat",
            message_type,
            self.inbox.store,
            node_name="/listener",
            report=lambda level, text: self.reports.append((level, text)),
            on_connection=self.inbox.store_header,
            on_close=self._release,
            tcp_nodelay=tcp_nodelay,
        )

    async def _release(self, subscription: Subscription) -> None:
        self.closed.append(subscription)


@contextlib.asynccontextmanager
async def subscribed(message_type: MessageType = STRING, *, tcp_nodelay: bool = True) -> AsyncIterator[Stage]:
    stage = Stage(message_type, tcp_nodelay=tcp_nodelay)
    try:
        yield stage
    finally:
        await stage.topic.close()


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publisher_connection, "FIRST_RETRY_S", 0.005)
    monkeypatch.setattr(publisher_connection, "MAX_RETRY_S", 0.02)
    monkeypatch.setattr(publisher_connection, "DRAIN_S", 0.1)


def fake(fields: Mapping[str, str] | None = None) -> FakePublisher:
    publisher = FakePublisher()
    publisher.header |= fields or {}
    return publisher


@pytest.mark.parametrize("tcp_nodelay", [True, False])
async def test_a_publisher_receives_the_requested_header(tcp_nodelay: bool) -> None:
    async with fake() as publisher, subscribed(tcp_nodelay=tcp_nodelay) as stage:
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        assert publisher.requests == [
            {
                "callerid": "/listener",
                "md5sum": STRING.md5sum,
                "message_definition": STRING.definition,
                "tcp_nodelay": "1" if tcp_nodelay else "0",
                "topic": "/chat",
                "type": STRING.name,
            }
        ]
        assert stage.inbox.headers == [publisher.header]
        wire = encode_messages([b"one", b"", b"two"])
        for byte in wire:
            publisher.peers[0].writer.write(bytes([byte]))
            await asyncio.sleep(0)
        await until(lambda: len(stage.inbox.payloads) == 3)
        assert stage.inbox.payloads == [b"one", b"", b"two"]
        (connection,) = stage.topic.connections
        assert connection.record.byte_count == len(wire)
        assert connection.record.message_count == 3
        assert connection.record.peer == publisher.uri


async def test_a_broken_connection_is_made_again() -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.add_publishers([publisher.uri])
        for count in range(1, 4):
            await until(lambda: len(publisher.peers) == count)  # noqa: B023 - awaited at once
            publisher.peers[-1].writer.write(encode_messages([b"%d" % count]) + b"\x09\0\0\0half")
            await publisher.peers[-1].close()
        await until(lambda: len(stage.inbox.payloads) == 3)
        assert stage.inbox.payloads == [b"1", b"2", b"3"]


async def test_a_length_above_the_limit_ends_the_connection_not_the_subscription(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: publisher.peers)
        publisher.peers[0].writer.write(encode_messages([b"good"]) + struct.pack("<I", 0xFFFFFFFF))
        await until(lambda: len(publisher.peers) == 2)
        publisher.peers[1].writer.write(encode_messages([b"again"]))
        await until(lambda: b"again" in stage.inbox.payloads)
        assert "message of 4294967295 bytes, more than" in caplog.text


@pytest.mark.parametrize(
    "answer",
    [
        [0, "no supported protocol implementations", []],
        [-1, "Not a publisher of [/chat]", []],
        [1, "", ["UDPROS", "127.0.0.1", 1]],
        [1, "", ["TCPROS"]],
        [1, "", []],
        [1, "", ["TCPROS", "127.0.0.1", "port"]],
        [1, "", ["TCPROS", "127.0.0.1", 99999]],
        [1, "", ["TCPROS", "no such host", 9]],
        "nonsense",
    ],
)
async def test_a_publisher_that_refuses_is_asked_again(answer: object) -> None:
    async with fake() as publisher, subscribed() as stage:
        later = publisher.answer
        publisher.answer = lambda self: answer if self.asked < 3 else later(self)
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        assert publisher.asked == 3
        assert stage.reports == []


async def test_a_type_that_differs_is_reported_once_and_not_tried_again() -> None:
    header = {"md5sum": "1" * 32, "type": "other/Type"}
    async with fake(header) as wrong, fake() as right, subscribed() as stage:
        stage.topic.add_publishers([wrong.uri, right.uri])
        await until(lambda: stage.topic.publisher_count == 1 and stage.reports)
        ((level, text),) = stage.reports
        assert level is Level.WARN
        assert "cannot subscribe to /chat" in text
        assert "other/Type" in text
        # While the other publisher reconnects three times, there is time for a retry.
        for count in range(1, 4):
            await until(lambda: len(right.peers) == count)  # noqa: B023 - awaited at once
            await right.peers[-1].close()
        assert wrong.asked == 1


async def test_an_error_header_is_reported_as_a_mismatch() -> None:
    publisher = fake()
    publisher.header = {"error": "topic types do not match: [std_msgs/String] vs. [std_msgs/Bool]"}
    async with publisher, subscribed() as stage:
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.reports)
        assert "[std_msgs/String] vs. [std_msgs/Bool]" in stage.reports[0][1]


async def test_a_subscriber_of_any_type_accepts_each_type() -> None:
    other = {"md5sum": "1" * 32, "type": "other/Type"}
    async with fake(other) as publisher, subscribed(ANY_MESSAGE) as stage:
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.inbox.headers)
        assert publisher.requests[0]["md5sum"] == "*"
        assert stage.inbox.headers[0]["type"] == "other/Type"


async def test_publishers_come_and_go_with_the_masters_list() -> None:
    async with fake() as first, fake() as second, subscribed() as stage:
        stage.topic.set_publishers([first.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        # The answer to a registration may be older than the last list, so its publishers are only added.
        stage.topic.add_publishers([second.uri])
        await until(lambda: stage.topic.publisher_count == 2)
        stage.topic.set_publishers([second.uri])
        assert await first.peers[0].is_hung_up()
        second.peers[0].writer.write(encode_messages([b"still here"]))
        await until(lambda: stage.inbox.payloads)
        assert (first.asked, second.asked) == (1, 1)


async def test_the_last_messages_of_a_publisher_that_has_ended_arrive() -> None:
    """A busy subscriber may detect the end before it reads the messages."""
    async with fake() as publisher, subscribed() as stage:
        stage.topic.set_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        publisher.peers[0].writer.write(encode_messages([b"x" * 1000] * 1000))
        stage.topic.set_publishers([])
        await publisher.peers[0].close()
        await until(lambda: len(stage.inbox.payloads) == 1000)
        await until(lambda: stage.topic.publisher_count == 0)
        assert publisher.asked == 1


async def test_many_empty_messages_of_one_read_leave_turns_to_other_tasks() -> None:
    async with fake() as publisher, subscribed() as stage:
        counts = [0]
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        publisher.peers[0].writer.write(encode_messages([b""] * 100_000 + [b"last"]))
        closing = asyncio.create_task(publisher.peers[0].close())
        while not stage.inbox.payloads or stage.inbox.payloads[-1] != b"last":
            await asyncio.sleep(0)
            counts.append(len(stage.inbox.payloads))
        assert counts[-1] == 100_001
        assert max(after - before for before, after in itertools.pairwise(counts)) <= TURN_MESSAGES
        await closing


async def test_a_pause_in_the_middle_of_a_read_loses_nothing() -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        publisher.peers[0].writer.write(encode_messages([b"%d" % number for number in range(30_000)]))
        await publisher.peers[0].close()
        for count in range(TURN_MESSAGES, 30_000, TURN_MESSAGES):
            await until(lambda: len(stage.inbox.payloads) >= count)  # noqa: B023 - awaited at once
            stage.topic.pause()
            await asyncio.sleep(0.001)
            stage.topic.resume()
        await until(lambda: len(stage.inbox.payloads) == 30_000)
        assert stage.inbox.payloads == [b"%d" % number for number in range(30_000)]


async def test_a_publisher_that_registers_again_keeps_its_connection() -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.set_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        stage.topic.set_publishers([])
        stage.topic.set_publishers([publisher.uri])
        await asyncio.sleep(2.5 * publisher_connection.DRAIN_S)
        publisher.peers[0].writer.write(encode_messages([b"once"]))
        await until(lambda: stage.inbox.payloads == [b"once"])
        assert publisher.asked == 1


@pytest.mark.parametrize("uri", ["http://127.0.0.1:1/", "nonsense", "rosrpc://127.0.0.1:1"])
async def test_a_publisher_that_does_not_answer_is_reported_once(uri: str) -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.set_publishers([uri, publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1 and stage.reports)
        assert uri in stage.reports[0][1]
        assert "ROS_IP" in stage.reports[0][1]
        # While the other publisher reconnects three times, there is time for a second report.
        for count in range(1, 4):
            await until(lambda: len(publisher.peers) == count)  # noqa: B023 - awaited at once
            await publisher.peers[-1].close()
        assert len(stage.reports) == 1
        stage.topic.set_publishers([publisher.uri])


async def test_a_message_right_after_the_header_waits_for_a_paused_subscriber() -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.pause()
        publisher.header["latching"] = "1"
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: publisher.peers)
        publisher.peers[0].writer.write(encode_messages([b"latched"]))
        await until(lambda: stage.inbox.headers)
        assert stage.inbox.payloads == []
        stage.topic.resume()
        await until(lambda: stage.inbox.payloads == [b"latched"])


async def test_closing_ends_the_connection_permanently() -> None:
    async with fake() as publisher, subscribed() as stage:
        stage.topic.add_publishers([publisher.uri])
        await until(lambda: stage.topic.publisher_count == 1)
        await stage.topic.close()
        await stage.topic.close()
        assert stage.closed == [stage.topic]
        stage.topic.add_publishers([publisher.uri])
        stage.topic.set_publishers([publisher.uri])
        assert await publisher.peers[0].is_hung_up()
        assert publisher.asked == 1
        assert stage.topic.publisher_count == 0
