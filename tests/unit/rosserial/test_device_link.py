from __future__ import annotations

import pytest

from rostether.errors import LocalProtocolError
from rostether.rosserial import device_state
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import (
    ABANDON_AFTER_S,
    MAX_WAITING_BYTES,
    MAX_WAITING_CONTROL_BYTES,
    DeviceLink,
    DeviceLinkConfig,
)
from rostether.rosserial.device_state import TRANSITIONS
from rostether.rosserial.events import (
    DeviceEvent,
    DiscardReason,
    FrameDiscarded,
    MessagesReceived,
    ParameterReceived,
    ParameterTimedOut,
    StopReceived,
    TimeAnswered,
    TopicsRequested,
    Unconfigured,
    UnknownTopicId,
)
from rostether.rosserial.packets import Log, LogLevel, ParameterResponse, TopicInfo, encode_time
from rostether.rosserial.time_sync import OUR_REQUEST_PERIOD_S, SYNC_LOST_S
from rostether.rostime import Time
from unit.rosserial.decoding import frame, plain_decode
from unit.rosserial.sessions import (
    EMPTY,
    EMPTY_MD5,
    STRING,
    STRING_MD5,
    TEST_REQUEST_MD5,
    TEST_RESPONSE_MD5,
    TEST_SRV,
)
from unit.rosserial.state_tables import drawn_transitions

REQUEST = frame(ids.TOPIC_REQUEST, b"")
TIME = frame(ids.TIME, bytes(8))
PROBE = b"\xff\x00"


def device(**options: int) -> tuple[DeviceLink, int, int]:
    link = DeviceLink(DeviceLinkConfig(**options))
    ids_of = link.add_publisher("chatter", STRING, STRING_MD5), link.add_subscriber("led", EMPTY, EMPTY_MD5)
    link.start(100.0)
    return link, *ids_of


def configured(**options: int) -> tuple[DeviceLink, int, int]:
    link, publisher, subscriber = device(**options)
    assert link.receive_data(frame(ids.TOPIC_REQUEST, b"", options.get("version", 2)), 100.0) == [
        TopicsRequested()
    ]
    link.data_to_send()
    return link, publisher, subscriber


def answer(seconds: float) -> bytes:
    return frame(ids.TIME, encode_time(Time.from_s(seconds)))


def test_the_table_is_the_one_that_is_drawn() -> None:
    drawn = {(state, what): following for state, what, following, _ in drawn_transitions(device_state)}
    assert drawn == {(state.name, what.name): after.name for (state, what), (after, _) in TRANSITIONS.items()}


def test_endpoints_are_numbered_and_announced_as_the_established_library_does() -> None:
    link, publisher, subscriber = device()
    service = link.add_service_server("ask", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
    client = link.add_service_client("call", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
    assert (publisher, subscriber) == (125, 100)
    assert (service.response_id, service.request_id) == (126, 101)
    assert (client.request_id, client.response_id) == (127, 102)
    assert link.data_to_send() == b""
    link.receive_data(REQUEST, 100.0)
    assert list(plain_decode(link.data_to_send())) == [
        (ids.TIME, bytes(8)),
        (ids.PUBLISHER, TopicInfo(125, "chatter", STRING, STRING_MD5, 512).encode()),
        (ids.SERVICE_SERVER_RESPONSE, TopicInfo(126, "ask", TEST_SRV, TEST_RESPONSE_MD5, 512).encode()),
        (ids.SERVICE_CLIENT_REQUEST, TopicInfo(127, "call", TEST_SRV, TEST_REQUEST_MD5, 512).encode()),
        (ids.SUBSCRIBER, TopicInfo(100, "led", EMPTY, EMPTY_MD5, 512).encode()),
        (ids.SERVICE_SERVER_REQUEST, TopicInfo(101, "ask", TEST_SRV, TEST_REQUEST_MD5, 512).encode()),
        (ids.SERVICE_CLIENT_RESPONSE, TopicInfo(102, "call", TEST_SRV, TEST_RESPONSE_MD5, 512).encode()),
    ]


def test_a_request_in_the_middle_of_a_session_is_answered_again() -> None:
    link, publisher, _ = configured()
    assert link.receive_data(REQUEST, 105.0) == [TopicsRequested()]
    assert len(list(plain_decode(link.data_to_send()))) == 3
    assert link.publish(publisher, [b""])


def test_requests_that_arrive_together_are_answered_once() -> None:
    link, _, _ = device()
    assert link.receive_data(REQUEST * 4, 100.0) == [TopicsRequested()]


def test_endpoints_declared_while_configured_are_announced_immediately() -> None:
    link, _, _ = configured()
    topic_id = link.add_subscriber("late", EMPTY, EMPTY_MD5)
    service_ids = link.add_service_server("late_ask", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
    assert list(plain_decode(link.data_to_send())) == [
        (ids.SUBSCRIBER, TopicInfo(topic_id, "late", EMPTY, EMPTY_MD5, 512).encode()),
        (
            ids.SERVICE_SERVER_RESPONSE,
            TopicInfo(service_ids.response_id, "late_ask", TEST_SRV, TEST_RESPONSE_MD5, 512).encode(),
        ),
        (
            ids.SERVICE_SERVER_REQUEST,
            TopicInfo(service_ids.request_id, "late_ask", TEST_SRV, TEST_REQUEST_MD5, 512).encode(),
        ),
    ]


def test_publishes_only_when_configured() -> None:
    link, publisher, _ = device()
    assert not link.publish(publisher, [b"\0\0\0\0"])
    assert link.data_to_send() == b""
    link.receive_data(REQUEST, 100.0)
    link.data_to_send()
    assert link.publish(publisher, [b"\x01\0\0\0a", b"\0\0\0\0"])
    assert link.data_to_send() == frame(publisher, b"\x01\0\0\0a") + frame(publisher, b"\0\0\0\0")


def test_messages_that_cannot_be_published() -> None:
    link, publisher, subscriber = configured(output_buffer_bytes=280)
    assert link.publish(publisher, [bytes(272)])
    with pytest.raises(
        LocalProtocolError, match="273 bytes does not fit in the output buffer, which has room for 272"
    ):
        link.publish(publisher, [bytes(273)])
    with pytest.raises(LocalProtocolError, match="does not send on topic id 100"):
        link.publish(subscriber, [b""])


def test_too_much_waiting_is_refused_and_never_kept() -> None:
    link, publisher, _ = configured()
    while link.publish(publisher, [bytes(500)] * 100):
        assert link._outgoing_bytes < MAX_WAITING_BYTES + 60000
    link.data_to_send()
    assert link.publish(publisher, [b""])


def test_messages_and_unknown_ids() -> None:
    link, publisher, subscriber = configured()
    data = frame(subscriber, b"") * 3 + frame(101, b"x") + frame(publisher, b"")
    assert link.receive_data(data, 100.0) == [
        MessagesReceived(subscriber, [b""] * 3),
        UnknownTopicId(101, 1),
        UnknownTopicId(publisher, 1),
    ]


def test_a_frame_larger_than_the_input_buffer_is_discarded() -> None:
    link, _, subscriber = configured(input_buffer_bytes=150)
    (event,) = link.receive_data(frame(subscriber, bytes(151)), 100.0)
    assert isinstance(event, FrameDiscarded)
    assert event.reason is DiscardReason.TOO_LONG
    assert link.receive_data(frame(subscriber, bytes(150)), 100.0) == [
        MessagesReceived(subscriber, [bytes(150)])
    ]


def test_asks_for_the_time_at_its_own_pace() -> None:
    link, _, _ = configured()
    asked: list[float] = []
    while len(asked) < 3:
        due_s = link.get_timer()
        assert due_s is not None
        link.handle_timer(due_s)
        if link.data_to_send() == TIME:
            asked.append(due_s)
            link.receive_data(answer(1e9 + due_s), due_s + 0.01)
    assert asked == pytest.approx([100 + OUR_REQUEST_PERIOD_S * number for number in (1, 2, 3)])


def test_falls_silent_without_answers_and_is_configured_by_a_request() -> None:
    link, publisher, _ = configured()
    events: list[DeviceEvent] = []
    while not events:
        due_s = link.get_timer()
        assert due_s is not None
        events = link.handle_timer(due_s)
    assert events == [Unconfigured()]
    assert due_s == pytest.approx(100.0 + SYNC_LOST_S)
    assert not link.publish(publisher, [b""])
    assert link.get_timer() is None
    link.receive_data(REQUEST, 150.0)
    assert link.publish(publisher, [b""])


def test_only_an_unconfigured_device_answers_a_wrong_version() -> None:
    link, _, _ = device()
    link.receive_data(PROBE, 100.0)
    assert link.data_to_send() == TIME
    link.receive_data(frame(ids.TOPIC_REQUEST, b"", 1), 100.1)
    assert link.data_to_send() == TIME
    link.receive_data(REQUEST, 100.2)
    link.data_to_send()
    link.receive_data(PROBE, 100.3)
    assert link.data_to_send() == b""


def test_an_unfinished_frame_does_not_hide_a_probe_for_long() -> None:
    link, _, _ = device()
    link.receive_data(frame(100, bytes(100))[:50], 100.0)
    link.receive_data(PROBE, 100.1)
    link.handle_timer(100.1 + ABANDON_AFTER_S)
    assert link.data_to_send() == TIME


def test_a_reset_forgets_the_host() -> None:
    link, publisher, _ = configured()
    link.publish(publisher, [b""])
    link.start(200.0)
    assert link.data_to_send() == b""
    assert not link.is_configured
    assert link.time(203.5) == Time(3, 500_000_000)
    link.receive_data(REQUEST, 204.0)
    assert len(list(plain_decode(link.data_to_send()))) == 3


def test_the_clock_adds_half_the_round_trip() -> None:
    link, _, _ = device()
    assert link.time(101.0) == Time(1, 0)
    link.receive_data(REQUEST, 102.0)
    events = link.receive_data(answer(1_700_000_000), 102.1)
    assert isinstance(events[0], TimeAnswered)
    assert link.statistics.shortest_round_trip_s == pytest.approx(0.1)
    assert link.time(102.1).to_s() == pytest.approx(1_700_000_000.05)
    assert link.time(112.1).to_s() == pytest.approx(1_700_000_010.05)


def test_stop() -> None:
    link, publisher, _ = configured()
    assert link.receive_data(frame(ids.TX_STOP, b""), 101.0) == [StopReceived(), Unconfigured()]
    assert not link.publish(publisher, [b""])
    link.receive_data(REQUEST, 102.0)
    assert link.is_configured


def test_a_host_that_reads_nothing_does_not_fill_the_memory() -> None:
    link, _, _ = configured()
    for _ in range(30):
        link.receive_data(REQUEST * 1000, 100.0)
        for _ in range(1000):
            link.log(LogLevel.INFO, "x" * 400)
    assert MAX_WAITING_CONTROL_BYTES < len(link.data_to_send()) < MAX_WAITING_CONTROL_BYTES + 1000
    link.log(LogLevel.INFO, "again")
    assert link.data_to_send()


def test_logs_are_sent_even_unconfigured_and_truncated_to_the_buffer() -> None:
    link, _, _ = device(output_buffer_bytes=150)
    link.log(LogLevel.ERROR, "motor stuck")
    link.log(LogLevel.INFO, "ä" * 200)
    frames = list(plain_decode(link.data_to_send()))
    assert frames[0] == (ids.LOG, Log(LogLevel.ERROR, "motor stuck").encode())
    assert frames[1] == (ids.LOG, Log(LogLevel.INFO, "ä" * 68).encode())


class TestParameters:
    def test_one_request_at_a_time_is_on_the_wire(self) -> None:
        link, _, _ = configured()
        link.request_parameter("~rate", 100.0)
        link.request_parameter("~name", 100.0)
        assert list(plain_decode(link.data_to_send())) == [(ids.PARAMETER, b"\x05\0\0\0~rate")]
        response = frame(ids.PARAMETER, ParameterResponse((10,)).encode())
        assert link.receive_data(response, 100.1) == [ParameterReceived("~rate", (10,), (), ())]
        assert list(plain_decode(link.data_to_send())) == [(ids.PARAMETER, b"\x05\0\0\0~name")]

    def test_a_parameter_that_does_not_exist(self) -> None:
        link, _, _ = configured()
        link.request_parameter("~none", 100.0)
        response = frame(ids.PARAMETER, ParameterResponse().encode())
        assert link.receive_data(response, 100.1) == [ParameterReceived("~none", (), (), ())]

    def test_no_answer_in_time(self) -> None:
        link, _, _ = configured()
        link.request_parameter("~rate", 100.0, timeout_s=0.5)
        link.request_parameter("~name", 100.0, timeout_s=0.5)
        assert link.get_timer() == 100.5
        assert link.handle_timer(100.5) == [ParameterTimedOut("~rate")]
        assert link.handle_timer(101.0) == [ParameterTimedOut("~name")]

    def test_an_answer_without_a_request(self) -> None:
        link, _, _ = configured()
        payload = ParameterResponse((1,)).encode()
        assert link.receive_data(frame(ids.PARAMETER, payload), 100.1) == [
            FrameDiscarded(DiscardReason.UNEXPECTED, payload)
        ]

    def test_requests_that_cannot_be_made(self) -> None:
        link, _, _ = configured()
        with pytest.raises(LocalProtocolError, match="is not a parameter name"):
            link.request_parameter("", 100.0)
        with pytest.raises(LocalProtocolError, match="too many"):
            for _ in range(100):
                link.request_parameter("~a", 100.0)


class TestDeclarations:
    def test_no_room(self) -> None:
        link = DeviceLink(DeviceLinkConfig(max_publishers=1, max_subscribers=1))
        link.add_publisher("a", STRING, STRING_MD5)
        with pytest.raises(LocalProtocolError, match="no room for a service"):
            link.add_service_server("s", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
        with pytest.raises(LocalProtocolError, match="all 1 publishers are declared"):
            link.add_publisher("b", STRING, STRING_MD5)
        link.add_subscriber("b", STRING, STRING_MD5)
        with pytest.raises(LocalProtocolError, match="all 1 subscribers are declared"):
            link.add_subscriber("c", STRING, STRING_MD5)

    @pytest.mark.parametrize(
        ("name", "message_type", "md5sum"),
        [
            ("a b", STRING, STRING_MD5),
            ("a", "String", STRING_MD5),
            ("a", STRING, "*"),
            ("x" * 300, STRING, STRING_MD5),
        ],
    )
    def test_announcements_that_hosts_refuse(self, name: str, message_type: str, md5sum: str) -> None:
        with pytest.raises(LocalProtocolError, match="a host would reject"):
            DeviceLink().add_publisher(name, message_type, md5sum)


@pytest.mark.parametrize(
    ("topic_id", "payload"),
    [
        (ids.TOPIC_REQUEST, b"x"),
        (ids.TIME, bytes(7)),
        (ids.TIME, b"\xff" * 8),
        (ids.PARAMETER, b"\x01\0\0\0"),
    ],
)
def test_control_packets_without_their_layout_are_not_believed(topic_id: int, payload: bytes) -> None:
    link, _, _ = device()
    assert link.receive_data(frame(topic_id, payload), 100.0) == [
        FrameDiscarded(DiscardReason.PACKET, payload)
    ]
    assert link.data_to_send() == b""


def test_version_1() -> None:
    link, publisher, subscriber = configured(version=1)
    assert link.receive_data(frame(subscriber, b"", 1), 100.0) == [MessagesReceived(subscriber, [b""])]
    link.publish(publisher, [b"x"])
    assert link.data_to_send() == frame(publisher, b"x", 1)
