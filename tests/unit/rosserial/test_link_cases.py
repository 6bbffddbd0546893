"""One table of what both links do with bytes; each case is replayed whole, byte by byte, with data behind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import pytest

from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink
from rostether.rosserial.events import (
    DeviceEvent,
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    MessagesReceived,
    ParameterReceived,
    ParameterRequested,
    ProtocolDetected,
    ServiceAnnounced,
    ServiceRole,
    StopReceived,
    TimeAnswered,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
    TopicsRequested,
    TopicWithdrawn,
    Unconfigured,
    UnknownTopicId,
)
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import Log, LogLevel, ParameterResponse, TopicInfo
from rostether.rostime import Time
from unit.rosserial.decoding import frame
from unit.rosserial.sessions import (
    EMPTY,
    EMPTY_MD5,
    STRING,
    STRING_MD5,
    TEST_REQUEST_MD5,
    TEST_RESPONSE_MD5,
    TEST_SRV,
)

REQUEST = frame(ids.TOPIC_REQUEST, b"")
TIME = frame(ids.TIME, bytes(8))
CHATTER = TopicInfo(125, "chatter", STRING, STRING_MD5, 512)
TALK = TopicInfo(125, "talk", STRING, STRING_MD5, 512)
LED = TopicInfo(100, "led", EMPTY, EMPTY_MD5, 512)
CALL = TopicInfo(126, "ask", TEST_SRV, TEST_REQUEST_MD5, 512)
RETURN = TopicInfo(101, "ask", TEST_SRV, TEST_RESPONSE_MD5, 512)
HELLO = frame(125, b"\x05\0\0\0hello")
PUBLISHER, SUBSCRIBER = TopicRole.PUBLISHER, TopicRole.SUBSCRIBER
CALL_FRAME = frame(ids.SERVICE_CLIENT_REQUEST, CALL.encode())
RETURN_FRAME = frame(ids.SERVICE_CLIENT_RESPONSE, RETURN.encode())
ANSWER = frame(ids.TIME, b"\x00\xf1\x53\x65\x00\x00\x00\x00")


def fresh_host() -> HostLink:
    link = HostLink()
    link.start(0.0)
    link.data_to_send()
    return link


def received_from_host() -> HostLink:
    link = fresh_host()
    link.receive_data(TIME, 0.0)
    link.data_to_send()
    return link


def settled_host() -> HostLink:
    link = received_from_host()
    while not link.is_settled:
        due_s = link.get_timer()
        assert due_s is not None
        link.handle_timer(due_s)
        if link.data_to_send():
            link.receive_data(TIME + frame(ids.PUBLISHER, CHATTER.encode()), due_s)
    return link


def fresh_device() -> DeviceLink:
    link = DeviceLink()
    link.add_publisher(CHATTER.topic_name, STRING, STRING_MD5)
    link.add_subscriber(LED.topic_name, EMPTY, EMPTY_MD5)
    link.start(0.0)
    return link


def configured_device() -> DeviceLink:
    link = fresh_device()
    link.receive_data(REQUEST, 0.0)
    link.receive_data(ANSWER, 0.0)
    link.data_to_send()
    return link


def asking_device() -> DeviceLink:
    link = configured_device()
    link.request_parameter("~rate", 0.0)
    link.data_to_send()
    return link


MAKE = {make.__name__: make for make in (fresh_host, received_from_host, settled_host)}
MAKE_DEVICE = {make.__name__: make for make in (fresh_device, configured_device, asking_device)}
BURST = TIME + frame(ids.PUBLISHER, CHATTER.encode()) + frame(ids.SUBSCRIBER, LED.encode())


@dataclass(frozen=True)
class Case:
    name: str
    state: str
    data: bytes
    events: Sequence[HostEvent | DeviceEvent] = ()
    sends: bytes = b""
    trailing: bytes = field(default=HELLO[:9])


CASES = [
    Case("first time request", "fresh_host", TIME, [ProtocolDetected(2), TimeRequested()]),
    Case("first version 1 time request", "fresh_host", frame(ids.TIME, bytes(8), 1),
         [ProtocolDetected(1), TimeRequested()], frame(ids.TOPIC_REQUEST, b"", 1), frame(125, b"hi", 1)[:5]),
    Case("announcements", "received_from_host", BURST,
         [TimeRequested(), TopicAnnounced(PUBLISHER, CHATTER), TopicAnnounced(SUBSCRIBER, LED)]),
    Case("both halves of a service", "received_from_host",
         CALL_FRAME + RETURN_FRAME,
         [ServiceAnnounced(ServiceRole.CLIENT, "ask", TEST_SRV, CALL, RETURN)]),
    Case("message on an id not yet announced", "received_from_host", HELLO, []),
    Case("log", "fresh_host", frame(ids.LOG, Log(LogLevel.FATAL, "smoke").encode()),
         [ProtocolDetected(2), LogReceived(LogLevel.FATAL, "smoke")]),
    Case("message", "settled_host", HELLO, [MessagesReceived(125, [b"\x05\0\0\0hello"])]),
    Case("announcement again", "settled_host", frame(ids.PUBLISHER, CHATTER.encode()), []),
    Case("announcement that changed", "settled_host", frame(ids.PUBLISHER, TALK.encode()),
         [TopicWithdrawn(PUBLISHER, CHATTER), TopicAnnounced(PUBLISHER, TALK)]),
    Case("unknown id", "settled_host", frame(130, b"x"), [UnknownTopicId(130)], REQUEST),
    Case("parameter request", "settled_host", frame(ids.PARAMETER, b"\x05\0\0\0~rate"),
         [ParameterRequested("~rate")]),
    Case("time request sooner than due", "settled_host", TIME, [TimeRequested()], b"\xff\x00"),
    Case("damage, so more may be missing", "settled_host", frame(ids.LOG, b"x"),
         [FrameDiscarded(DiscardReason.PACKET, b"x", ids.LOG)], REQUEST),
    Case("topic request asked of a host", "settled_host", REQUEST,
         [FrameDiscarded(DiscardReason.PACKET, b"", ids.PUBLISHER)], REQUEST),
    Case("stop asked of a host", "settled_host", frame(ids.TX_STOP, b""),
         [FrameDiscarded(DiscardReason.UNEXPECTED, b"")]),
    Case("topic request", "fresh_device", REQUEST, [TopicsRequested()], BURST, frame(100, b"")[:6]),
    Case("probe while unconfigured", "fresh_device", b"\xff\x00",
         [FrameDiscarded(DiscardReason.VERSION, b"\xff\x00")], TIME, frame(100, b"")[:6]),
    Case("probe while configured", "configured_device", b"\xff\x00",
         [FrameDiscarded(DiscardReason.VERSION, b"\xff\x00")], b"", frame(100, b"")[:6]),
    Case("message to the device", "configured_device", frame(100, b""), [MessagesReceived(100, [b""])]),
    Case("unknown id to the device", "configured_device", frame(105, b"x"), [UnknownTopicId(105)]),
    Case("time answer", "configured_device", ANSWER, [TimeAnswered(Time(0x6553F100))]),
    Case("parameter answer", "asking_device", frame(ids.PARAMETER, ParameterResponse((10,)).encode()),
         [ParameterReceived("~rate", (10,), (), ())]),
    Case("stop", "configured_device", frame(ids.TX_STOP, b""), [StopReceived(), Unconfigured()]),
]  # fmt: skip


def play(case: Case, chunks: Sequence[bytes]) -> tuple[list[HostEvent | DeviceEvent], bytes]:
    link = (MAKE | MAKE_DEVICE)[case.state]()
    events: list[HostEvent | DeviceEvent] = []
    for chunk in chunks:
        events += link.receive_data(chunk, 0.5)
    return events, link.data_to_send()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
class TestCases:
    def test_whole(self, case: Case) -> None:
        assert play(case, [case.data]) == (list(case.events), case.sends)

    def test_byte_by_byte(self, case: Case) -> None:
        chunks = [case.data[position : position + 1] for position in range(len(case.data))]
        assert play(case, chunks) == (list(case.events), case.sends)

    def test_with_trailing_data(self, case: Case) -> None:
        assert play(case, [case.data + case.trailing]) == (list(case.events), case.sends)
