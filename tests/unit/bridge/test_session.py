from __future__ import annotations

import asyncio
import random
import struct
from collections.abc import AsyncIterator
from typing import Any

import pytest

from rostether.bridge.board_node import BoardNode
from rostether.bridge.session import Session
from rostether.bridge.settings import BridgeSettings
from rostether.errors import ServiceCallError
from rostether.graph.ports import Level
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import Log, LogLevel, ParameterResponse, TopicInfo
from rostether.transports.memory import memory_pair
from unit.bridge.nodes import STORE, World, text, topic_info
from unit.bridge.raw_board import RawBoard
from unit.bridge.virtual_time import run
from waiting import until

STRING = STORE.registry.message_type("std_msgs/String")
SET_BOOL = STORE.registry.service_type("std_srvs/SetBool")
CHATTER = (ids.PUBLISHER, topic_info("chatter", topic_id=125))
LED = (ids.SUBSCRIBER, topic_info("led", topic_id=100))
LONG_CHATTER = (ids.PUBLISHER, topic_info("chatter", topic_id=125, buffer_size=2048))


def service_announcements(
    first_kind: int, name: str, publish_id: int, receive_id: int
) -> list[tuple[int, TopicInfo]]:
    """Request and response of a SetBool service; kinds 2, 3 are a server's, 4, 5 a client's."""
    halves = [SET_BOOL.response, SET_BOOL.request]
    if first_kind == ids.SERVICE_CLIENT_REQUEST:
        halves.reverse()
    return [
        (first_kind, TopicInfo(publish_id, name, "std_srvs/SetBool", halves[0].md5sum, 280)),
        (first_kind + 1, TopicInfo(receive_id, name, "std_srvs/SetBool", halves[1].md5sum, 280)),
    ]


class Bridge(World):
    """A world with a session and a raw board at its other end."""

    session: Session
    board_end: RawBoard
    node: BoardNode

    async def connect(
        self,
        *announcements: tuple[int, TopicInfo],
        can_pause: bool = True,
        settings: BridgeSettings | None = None,
        baud: int | None = None,
    ) -> RawBoard:
        loop = asyncio.get_running_loop()
        if not hasattr(self, "node"):
            self.node = BoardNode(self.board, STORE, self.reporter, loop.time, settings or BridgeSettings())
        ours, theirs = memory_pair(can_pause=can_pause)
        self.board_end = RawBoard(theirs, *announcements)
        self.session = Session(ours, self.node, baud=baud)
        self.session.start()
        return self.board_end

    async def settled(self) -> None:
        await until(lambda: self.session.link.is_settled, "the negotiation")

    async def close(self) -> None:
        if hasattr(self, "session"):
            await self.session.stop()
            await self.node.close()


@pytest.fixture
async def bridge() -> AsyncIterator[Bridge]:
    bridge = Bridge()
    await bridge.open()
    yield bridge
    await bridge.close()


async def test_a_board_announces_the_same_topics_to_established_hosts(bridge: Bridge) -> None:
    await bridge.connect(
        CHATTER,
        LED,
        *service_announcements(ids.SERVICE_SERVER_RESPONSE, "served", 126, 101),
        *service_announcements(ids.SERVICE_CLIENT_REQUEST, "called", 127, 102),
    )
    await bridge.settled()
    assert bridge.reporter.texts == [
        "Note: publish buffer size is 280 bytes",
        "Setup publisher on chatter [std_msgs/String]",
        "Note: subscribe buffer size is 280 bytes",
        "Setup subscriber on led [std_msgs/String]",
        "Setup service server on served [std_srvs/SetBool]",
        "Setup service client on called [std_srvs/SetBool]",
    ]
    await until(lambda: "/served" in bridge.network.snapshot().services, "the service")
    assert [log.text for log in bridge.network.logs] == bridge.reporter.texts


async def test_messages_flow_to_ros(bridge: Bridge) -> None:
    arrived = await bridge.listen("/chatter")
    board = await bridge.connect(CHATTER)
    await until(lambda: bridge.session.receivers, "the announcement")
    board.send(125, *(text(str(number)) for number in range(1000)))
    await until(lambda: len(arrived) == 1000, "all messages")
    assert arrived == [text(str(number)) for number in range(1000)]


async def test_messages_flow_to_the_board(bridge: Bridge) -> None:
    board = await bridge.connect(LED)
    publisher = await bridge.peer.advertise("/led", STRING)
    await until(lambda: publisher.subscriber_count == 1, "the subscription")
    publisher.publish_raw([text(str(number)) for number in range(1000)])
    await until(lambda: len(board.received[100]) == 1000, "all messages")
    assert board.received[100] == [text(str(number)) for number in range(1000)]


async def test_time_is_answered_immediately(bridge: Bridge) -> None:
    board = await bridge.connect(CHATTER)
    await bridge.settled()
    answered = len(board.received[ids.TIME])
    before = bridge.board.now()
    board.ask_time()
    await until(lambda: len(board.received[ids.TIME]) > answered, "the answer")
    secs, nsecs = struct.unpack("<II", board.received[ids.TIME][-1])
    assert before <= (secs, nsecs) <= bridge.board.now()


async def test_parameters_are_answered_missing_ones_too(bridge: Bridge) -> None:
    await bridge.peer.set_param("/board/gain", 2.5)
    board = await bridge.connect(CHATTER)
    board.ask_parameter("~gain")
    board.ask_parameter("missing")
    await until(lambda: len(board.received[ids.PARAMETER]) == 2, "the answers")
    assert [ParameterResponse.decode(payload) for payload in board.received[ids.PARAMETER]] == [
        ParameterResponse(floats=(2.5,)),
        ParameterResponse(),
    ]
    assert len(bridge.reporter.having("missing")) == 1


async def test_an_empty_time_request_is_answered_as_any_other(bridge: Bridge) -> None:
    board = await bridge.connect(CHATTER)
    await bridge.settled()
    answered = len(board.received[ids.TIME])
    for number in range(3):
        board.send(ids.TIME, b"")
        await until(lambda least=answered + number: len(board.received[ids.TIME]) > least, "the answer")  # type: ignore[misc]
    assert bridge.node.health.find(asyncio.get_running_loop().time()) == []


@pytest.mark.parametrize("buffer_size", [0, 11])
async def test_a_board_whose_buffer_is_too_small_for_answers_is_still_served(
    bridge: Bridge, buffer_size: int
) -> None:
    await bridge.peer.set_param("/gain", 3)
    small = (ids.SUBSCRIBER, topic_info("led", topic_id=100, buffer_size=buffer_size))
    board = await bridge.connect(small)
    await bridge.settled()
    board.ask_parameter("gain")
    await until(lambda: bridge.reporter.having("even an empty answer does not fit;"), "the line")
    board.ask_time()
    answered = len(board.received[ids.TIME])
    await until(lambda: len(board.received[ids.TIME]) > answered, "the time")
    assert not board.received[ids.PARAMETER]
    board.send(ids.SUBSCRIBER, topic_info("led", topic_id=100, buffer_size=280).encode())
    board.ask_parameter("gain")
    await until(lambda: board.received[ids.PARAMETER], "the answer")
    assert ParameterResponse.decode(board.received[ids.PARAMETER][0]) == ParameterResponse(ints=(3,))


@pytest.mark.parametrize(
    ("level", "shown"),
    [
        (LogLevel.DEBUG, Level.DEBUG),
        (LogLevel.INFO, Level.INFO),
        (LogLevel.WARN, Level.WARN),
        (LogLevel.ERROR, Level.ERROR),
        (LogLevel.FATAL, Level.FATAL),
    ],
)
async def test_logs_keep_their_level_and_their_node(bridge: Bridge, level: LogLevel, shown: Level) -> None:
    board = await bridge.connect(CHATTER)
    board.log(level, "battery low")
    await until(lambda: bridge.reporter.having("battery low"), "the line")
    assert (shown, "battery low", "/board") in bridge.reporter.lines
    (log,) = [log for log in bridge.network.logs if log.text == "battery low"]
    assert (log.node_name, log.level) == ("/board", shown)


async def test_a_call_from_ros_to_the_board(bridge: Bridge) -> None:
    board = await bridge.connect(*service_announcements(ids.SERVICE_SERVER_RESPONSE, "switch", 125, 100))
    await until(lambda: "/switch" in bridge.network.snapshot().services, "the service")
    call = asyncio.ensure_future(bridge.peer.call_service("/switch", SET_BOOL, b"\x01"))
    await until(lambda: board.received[100], "the request")
    board.send(125, b"\x01\x02\0\0\0ok")
    assert await call == b"\x01\x02\0\0\0ok"


async def test_a_call_from_the_board_to_ros(bridge: Bridge) -> None:
    release = asyncio.Event()

    async def answer(request: bytes) -> bytes:
        await release.wait()
        return b"\x01\x02\0\0\0ok"

    await bridge.peer.advertise_service("/switch", SET_BOOL, answer)
    board = await bridge.connect(*service_announcements(ids.SERVICE_CLIENT_REQUEST, "switch", 125, 100))
    await bridge.settled()
    answered = len(board.received[ids.TIME])
    board.send(125, b"\x01")
    board.ask_time()
    await asyncio.sleep(0.02)
    assert len(board.received[ids.TIME]) == answered, "a time answer would end the board's wait"
    release.set()
    await until(lambda: len(board.received[ids.TIME]) > answered, "the time answer")
    assert board.received[100] == [b"\x01\x02\0\0\0ok"]
    assert board.order.index(100) < len(board.order) - 1 - board.order[::-1].index(ids.TIME)


async def test_a_service_whose_ids_changed_without_a_reset_is_served(bridge: Bridge) -> None:
    async def answer(_: bytes) -> bytes:
        return b"\x01\x02\0\0\0ok"

    await bridge.peer.advertise_service("/switch", SET_BOOL, answer)
    board = await bridge.connect(
        *service_announcements(ids.SERVICE_CLIENT_REQUEST, "switch", 127, 102),
    )
    await bridge.settled()
    board.announcements = service_announcements(ids.SERVICE_CLIENT_REQUEST, "switch", 125, 100)
    for kind, info in board.announcements:
        board.send(kind, info.encode())
    await until(lambda: not bridge.session.link.is_settled, "another negotiation")
    await bridge.settled()
    board.send(125, b"\x01")
    await until(lambda: board.received[100], "the response")
    assert board.received[100] == [b"\x01\x02\0\0\0ok"]


def test_a_time_request_after_silence_shows_that_the_board_is_past_a_call(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rostether.bridge.endpoint.service_server.BUSY_S", 0.05)
    run(call_a_board_that_was_silent())


async def call_a_board_that_was_silent() -> None:
    bridge = Bridge()
    await bridge.open()
    settings = BridgeSettings(service_timeout_s=0.1)
    board = await bridge.connect(
        *service_announcements(ids.SERVICE_SERVER_RESPONSE, "switch", 125, 100), settings=settings
    )
    await until(lambda: "/switch" in bridge.network.snapshot().services, "the service")
    await bridge.settled()
    with pytest.raises(ServiceCallError, match="did not answer"):
        await bridge.peer.call_service("/switch", SET_BOOL, b"\x01")
    second = asyncio.ensure_future(bridge.peer.call_service("/switch", SET_BOOL, b"\x01"))
    await asyncio.sleep(0.01)
    assert len(board.received[100]) == 1
    board.ask_time()
    await until(lambda: len(board.received[100]) == 2, "the second request")
    board.send(125, b"\x01\x02\0\0\0ok")
    assert await second == b"\x01\x02\0\0\0ok"
    await bridge.close()


async def test_a_reset_ends_the_call_in_flight(bridge: Bridge) -> None:
    board = await bridge.connect(*service_announcements(ids.SERVICE_SERVER_RESPONSE, "switch", 125, 100))
    await until(lambda: "/switch" in bridge.network.snapshot().services, "the service")
    await bridge.settled()
    call = asyncio.ensure_future(bridge.peer.call_service("/switch", SET_BOOL, b"\x01"))
    await until(lambda: board.received[100], "the request")
    asked = len(board.received[ids.TOPIC_REQUEST])
    # A configured board requests the time every 2.5 s; two requests in a row come from a board that boots.
    for _ in range(3):
        board.ask_time()
        await asyncio.sleep(0.01)
    await until(lambda: len(board.received[ids.TOPIC_REQUEST]) > asked, "the bridge to notice")
    with pytest.raises(ServiceCallError, match="was reset during the call"):
        await asyncio.wait_for(call, 60.0)


async def test_stopping_sends_a_stop_to_the_board(bridge: Bridge) -> None:
    board = await bridge.connect(CHATTER)
    await bridge.settled()
    await bridge.session.stop()
    await until(lambda: board.is_lost, "the end")
    assert board.order[-1] == ids.TX_STOP
    assert not bridge.session.is_connected


async def test_the_plug_pulled_within_a_message(bridge: Bridge) -> None:
    arrived = await bridge.listen("/chatter")
    board = await bridge.connect(CHATTER)
    await until(lambda: bridge.session.receivers, "the announcement")
    frame = encode_frame(125, text("whole"))
    board.transport.write(frame + frame[:9])
    board.transport.close()
    assert await bridge.session.wait_ended() is not None
    await until(lambda: arrived, "the whole message")
    assert arrived == [text("whole")]
    assert "/board" in bridge.network.snapshot().topics["/chatter"].publishers
    again = await bridge.connect(CHATTER)
    await until(lambda: bridge.session.receivers, "the second announcement")
    again.send(125, text("back"))
    await until(lambda: len(arrived) == 2, "the message after the loss")
    assert arrived[1] == text("back")


async def test_garbage_causes_few_lines(bridge: Bridge) -> None:
    arrived = await bridge.listen("/chatter")
    board = await bridge.connect(CHATTER)
    await bridge.settled()
    rng = random.Random(7)
    for _ in range(200):
        board.transport.write(rng.randbytes(1000))
        for topic_id in (9, 12, 99, 300, rng.randrange(65536)):
            board.send(topic_id, rng.randbytes(rng.randrange(30)))
        await asyncio.sleep(0)
    board.transport.write(bytes(700))
    for number in range(50):
        board.send(125, text(f"good {number}"))
        await asyncio.sleep(0.01)
        if text(f"good {number}") in arrived:
            break
    assert any(payload.startswith(b"\x06\0\0\0good") or b"good" in payload for payload in arrived)
    assert all(STORE.layout("std_msgs/String").accepts(payload) for payload in arrived)
    assert len(bridge.reporter.lines) < 20


async def test_a_flood_of_log_lines_is_reported_in_one_line(bridge: Bridge) -> None:
    arrived = await bridge.listen("/chatter")
    board = await bridge.connect(CHATTER)
    await bridge.settled()
    line = encode_frame(ids.LOG, Log(LogLevel.INFO, "again").encode())
    for _ in range(3):
        board.transport.write(line * 2000)
    board.send(125, text("after"))
    await until(lambda: bool(arrived), "the message behind the flood")
    assert len(bridge.reporter.having("again")) < 4000
    assert len(bridge.reporter.having("too many log lines")) == 1


async def test_messages_of_topics_without_an_endpoint_are_ignored(bridge: Bridge) -> None:
    unknown = TopicInfo(126, "odd", "my_robot/Odd", "0" * 32, 280)
    board = await bridge.connect(CHATTER, (ids.PUBLISHER, unknown))
    await bridge.settled()
    statistics = bridge.session.link.statistics
    before = statistics.frames_received
    board.send(126, b"12345")
    await until(lambda: statistics.frames_received > before, "the message")
    assert len(bridge.reporter.having("my_robot")) == 1


async def test_a_topic_that_cannot_be_bridged_is_reported_in_one_line(bridge: Bridge) -> None:
    wheel = TopicInfo(126, "left-wheel", "std_msgs/String", STRING.md5sum, 280)
    await bridge.connect(CHATTER, (ids.PUBLISHER, wheel))
    await bridge.settled()
    (line,) = bridge.reporter.having("left-wheel")
    assert "left-wheel [std_msgs/String] is not bridged: " in line
    assert "write left_wheel in the sketch" in line


async def test_a_slow_subscriber_pauses_a_board_that_can_be_paused(bridge: Bridge) -> None:
    subscription = await bridge.peer.subscribe("/chatter", STRING, lambda _: None)
    board = await bridge.connect(LONG_CHATTER)
    await bridge.settled()
    subscription.pause()
    sent = 0
    while board.transport.write_buffer_bytes < 65536 and sent < 2000:
        board.send(125, text("x" * 1000))
        sent += 1
        await asyncio.sleep(0)
    assert sent < 2000, "the board was never paused"
    subscription.resume()
    await until(lambda: board.transport.write_buffer_bytes == 0, "the board to go on")


async def test_a_subscriber_that_hangs_pauses_the_board_only_briefly(bridge: Bridge) -> None:
    arrived = await bridge.listen("/chatter")
    hanging = await bridge.network.join("/hanging")
    subscription = await hanging.subscribe("/chatter", STRING, lambda _: None)
    board = await bridge.connect(LONG_CHATTER)
    await bridge.settled()
    subscription.pause()
    total = 8000
    for _ in range(total):
        while board.transport.write_buffer_bytes > 30_000:
            await asyncio.sleep(0.001)
        board.send(125, text("x" * 1000))
    await until(lambda: len(arrived) == total, "all at the quick subscriber")


async def test_a_hanging_board_stops_no_publisher_for_long(bridge: Bridge) -> None:
    board = await bridge.connect(LED, settings=BridgeSettings(stall_s=0.2))
    publisher = await bridge.peer.advertise("/led", STRING)
    await bridge.settled()
    board.transport.pause_reading()
    while publisher.publish_raw([text("x" * 200)] * 100):
        await asyncio.sleep(0)
    await publisher.drained(5.0)
    for _ in range(30):
        publisher.publish_raw([text("x" * 200)] * 100)
        await asyncio.sleep(0)
    await until(lambda: bridge.reporter.having("led is faster than the board can receive"), "the line")
    board.transport.resume_reading()
    publisher.publish_raw([text("last")])
    await until(lambda: board.received[100][-1:] == [text("last")], "the newest message")


async def test_a_defect_ends_only_this_session(bridge: Bridge, monkeypatch: pytest.MonkeyPatch) -> None:
    board = await bridge.connect(CHATTER)
    await bridge.settled()

    def broken(*_: Any) -> None:
        raise RuntimeError("a defect of ours")

    monkeypatch.setattr(bridge.session.link, "receive_data", broken)
    board.send(125, text("x"))
    await until(lambda: not bridge.session.is_connected, "the end of the session")
    (reported,) = bridge.reporter.having("failed")
    assert "a defect of ours" in reported


async def test_an_unplugged_serial_line_is_paced(bridge: Bridge) -> None:
    board = await bridge.connect(LED, can_pause=False, baud=9600)
    await bridge.settled()
    publisher = await bridge.peer.advertise("/led", STRING)
    await until(lambda: publisher.subscriber_count == 1, "the subscription")
    publisher.publish_raw([text("x" * 88)] * 50)
    board.ask_time()
    answered = len(board.received[ids.TIME])
    await until(lambda: len(board.received[ids.TIME]) > answered, "the time answer")
    assert len(board.received[100]) < 10
    assert bridge.session.outbox.queued_bytes > 0
