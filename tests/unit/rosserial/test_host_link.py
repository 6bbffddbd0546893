"""Messages, services and statistics through a settled link."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink
from rostether.rosserial.events import (
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    MessagesReceived,
    ParameterRequested,
    ProtocolDetected,
    TimeRequested,
    TopicAnnounced,
)
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import Log, LogLevel, decode_time
from rostether.rosserial.time_sync import HOLD_LIMIT_S
from rostether.rostime import Time
from unit.rosserial.decoding import can_send, frame, plain_decode
from unit.rosserial.host_link_boards import (
    BURST,
    REQUEST,
    TIME,
    line_to,
    only,
    settled_link,
    small_device,
)
from unit.rosserial.sessions import (
    TEST_REQUEST_MD5,
    TEST_RESPONSE_MD5,
    TEST_SRV,
)


class TestMessages:
    def test_batches_equal_single_frames(self) -> None:
        link, _ = settled_link()
        payloads = [bytes([number]) * number for number in range(100)]
        expected = b"".join(frame(100, payload) for payload in payloads)
        assert link.encode_messages(100, payloads) == expected
        assert link.encode_messages(100, []) == b""

    def test_never_more_than_the_buffer_nor_an_unknown_id(self) -> None:
        link, _ = settled_link()
        assert link.encode_message(100, bytes(150))
        with pytest.raises(
            LocalProtocolError, match="151 bytes does not fit in the device's buffer of 150 bytes"
        ):
            link.encode_messages(100, [b"", bytes(151)])
        for topic_id in (125, 101, 7, 0):
            with pytest.raises(LocalProtocolError, match="has not announced a subscriber with"):
                link.encode_message(topic_id, b"")

    def test_messages_of_a_chunk_are_reported_after_its_announcements(self) -> None:
        link = HostLink()
        link.start(0.0)
        events = link.receive_data(frame(125, b"a") + BURST + frame(125, b"b"), 0.0)
        assert events[-1] == MessagesReceived(125, [b"a", b"b"])
        assert len(only(events, TopicAnnounced)) == 2

    def test_ids_that_mean_nothing_from_a_device(self) -> None:
        link, now_s = settled_link()
        for topic_id in (8, 9, 11, 12, 99):
            assert link.receive_data(frame(topic_id, b"x"), now_s) == [
                FrameDiscarded(DiscardReason.UNEXPECTED, b"x")
            ]

    def test_noise_is_an_event_and_counted(self) -> None:
        link, now_s = settled_link()
        assert link.receive_data(b"Hello\r\n", now_s) == [FrameDiscarded(DiscardReason.NOISE, b"Hello\r\n")]
        assert link.statistics.discarded == {DiscardReason.NOISE: 1}
        assert link.statistics.discarded_bytes == 7

    def test_text_on_a_line_without_any_frame_is_reported(self) -> None:
        link = HostLink()
        link.start(0.0)
        assert link.receive_data(b"Marlin 2.1\r\n", 1.0) == []
        due_s = link.get_timer()
        events: list[HostEvent] = []
        while due_s is not None and due_s < 2.0:
            events += link.handle_timer(due_s)
            due_s = link.get_timer()
        assert FrameDiscarded(DiscardReason.NOISE, b"Marlin 2.1\r\n") in events


class TestServices:
    def test_logs(self) -> None:
        link, now_s = settled_link()
        payload = Log(LogLevel.WARN, "low battery").encode()
        assert link.receive_data(frame(ids.LOG, payload), now_s) == [
            LogReceived(LogLevel.WARN, "low battery")
        ]

    def test_logs_and_time_requests_before_any_negotiation(self) -> None:
        link = HostLink()
        link.start(0.0)
        link.data_to_send()
        log = frame(ids.LOG, Log(LogLevel.INFO, "setup").encode())
        events = link.receive_data(log + TIME, 1.0)
        assert events == [ProtocolDetected(2), LogReceived(LogLevel.INFO, "setup"), TimeRequested()]

    def test_parameters(self) -> None:
        link, now_s = settled_link()
        assert link.receive_data(frame(ids.PARAMETER, b"\x05\0\0\0~rate"), now_s) == [
            ParameterRequested("~rate")
        ]
        link.answer_parameter([10])
        assert link.data_to_send() == frame(ids.PARAMETER, bytes.fromhex("010000000a0000000000000000000000"))
        link.answer_parameter()
        assert link.data_to_send() == frame(ids.PARAMETER, bytes(12))

    def test_a_parameter_larger_than_the_buffer_is_refused(self) -> None:
        link, _ = settled_link()
        with pytest.raises(LocalProtocolError, match="needs 212 bytes"):
            link.answer_parameter(ints=[1] * 50)
        link.answer_parameter(ints=[1] * 30)

    def test_time_is_answered_immediately(self) -> None:
        link, now_s = settled_link()
        assert TimeRequested() in link.receive_data(TIME, now_s)
        link.answer_time(Time(1700000000, 5), now_s)
        assert list(plain_decode(link.data_to_send())) == [(ids.TIME, bytes.fromhex("00f1536505000000"))]

    def test_time_waits_for_the_boards_own_call(self) -> None:
        link, now_s = settled_link()
        link.service_call_started()
        link.answer_time(Time(1700000000, 0), now_s)
        assert link.data_to_send() == b""
        response = link.encode_message(100, b"")
        link.service_call_finished(now_s + 0.5)
        assert response
        ((topic_id, payload),) = plain_decode(link.data_to_send())
        assert topic_id == ids.TIME
        assert decode_time(payload) == Time(1700000000, 500_000_000)

    def test_held_frames_wait_for_a_limited_time(self) -> None:
        link, now_s = settled_link()
        link.service_call_started()
        link.answer_time(Time(1700000000, 0), now_s)
        end_s = now_s + HOLD_LIMIT_S + 0.01
        sent = b""
        while now_s < end_s:
            due_s = link.get_timer()
            assert due_s is not None
            now_s = min(due_s, end_s)
            link.receive_data(frame(125, b"\0\0\0\0"), now_s)
            link.handle_timer(now_s)
            sent += link.data_to_send()
        assert any(topic_id == ids.TIME for topic_id, _ in plain_decode(sent))

    def test_topic_requests_wait_for_the_boards_own_call_too(self) -> None:
        link, now_s = settled_link()
        link.service_call_started()
        link.receive_data(frame(126, b""), now_s)
        assert link.data_to_send() == b""
        link.service_call_finished(now_s + 0.1)
        assert link.data_to_send() == REQUEST

    def test_stop(self) -> None:
        link, now_s = settled_link()
        link.answer_parameter()
        link.stop()
        assert link.data_to_send() == frame(ids.TX_STOP, b"")
        assert link.get_timer() is None
        assert link.handle_timer(now_s + 100) == []
        assert link.receive_data(TIME, now_s + 100) == []

    def test_services_of_both_kinds(self) -> None:
        device = DeviceLink()
        served = device.add_service_server("serve", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
        called = device.add_service_client("call", TEST_SRV, TEST_REQUEST_MD5, TEST_RESPONSE_MD5)
        line = line_to(device)
        assert line.run_until(lambda: line.host.is_settled, 1.0)
        assert can_send(line.host, served.request_id)
        assert can_send(line.host, called.response_id)
        device.publish(called.request_id, [b"\0\0\0\0"])
        line.flush()
        line.run(0.1)
        assert line.events_of(MessagesReceived) == [MessagesReceived(called.request_id, [b"\0\0\0\0"])]


def test_statistics() -> None:
    device, publisher, _ = small_device()
    line = line_to(device, latency_s=0.005)
    line.run_until(lambda: line.host.is_settled, 1.0)
    device.publish(publisher, [b"\0\0\0\0"] * 7)
    line.flush()
    line.run(3.0)
    statistics = line.host.statistics
    assert statistics.bytes_received == len(line.sent_by_device)
    assert statistics.time_requests == 3
    assert statistics.shortest_round_trip_s == pytest.approx(0.01, abs=0.001)
    assert statistics.damaged_frames == 0
    frames = Counter(topic_id for topic_id, _ in plain_decode(bytes(line.sent_by_device)))
    assert statistics.frames_received == frames.total()


def test_random_bytes_never_raise() -> None:
    rng = random.Random(9)
    for _ in range(50):
        link, now_s = settled_link()
        for _ in range(40):
            now_s += rng.random()
            topic_id = rng.choice((*range(13), 100, 125, 126, 70))
            pieces = (
                rng.randbytes(rng.randrange(40)),
                frame(topic_id, rng.randbytes(rng.randrange(30))),
                BURST,
            )
            link.receive_data(rng.choice(pieces), now_s)
            link.handle_timer(now_s)
            link.data_to_send()
