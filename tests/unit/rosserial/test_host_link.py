from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace
from typing import Any

import pytest

from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.events import (
    AnnouncementRefused,
    DeviceReset,
    DeviceSilent,
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    MessagesReceived,
    NegotiationSettled,
    ParameterRequested,
    ProtocolDetected,
    TimeRequested,
    TopicAnnounced,
    TopicWithdrawn,
    UnknownTopicId,
)
from rostether.rosserial.host_link import HostLink, HostLinkConfig
from rostether.rosserial.packets import Log, LogLevel, TopicInfo, decode_time
from rostether.rosserial.time_sync import HOLD_LIMIT_S
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
    Line,
    declare_many,
    lose_or_damage,
    pass_unharmed,
)

REQUEST = frame(ids.TOPIC_REQUEST, b"")
CHATTER = TopicInfo(125, "chatter", STRING, STRING_MD5, 280)
LED = TopicInfo(100, "led", EMPTY, EMPTY_MD5, 150)
TIME = frame(ids.TIME, bytes(8))
BURST = TIME + frame(ids.PUBLISHER, CHATTER.encode()) + frame(ids.SUBSCRIBER, LED.encode())


def line_to(device: DeviceLink, **options: object) -> Line:
    line = Line(HostLink(), device, **options)  # type: ignore[arg-type]
    line.start()
    return line


def small_device(version: int = 2) -> tuple[DeviceLink, int, int]:
    device = DeviceLink(DeviceLinkConfig(version=version))
    return (
        device,
        device.add_publisher("chatter", STRING, STRING_MD5),
        device.add_subscriber("led", EMPTY, EMPTY_MD5),
    )


def settled_link() -> tuple[HostLink, float]:
    """Return a link that has settled on CHATTER and LED, and the time."""
    link, now_s, _ = settle_on(BURST)
    return link, now_s


def settle_on(burst: bytes) -> tuple[HostLink, float, list[HostEvent]]:
    """Return a new link that has settled on what is announced here, the time, and what was reported."""
    link = HostLink()
    link.start(0.0)
    now_s, events = run_to_settled(link, 0.0, burst)
    return link, now_s, events


def run_to_settled(link: HostLink, now_s: float, burst: bytes) -> tuple[float, list[HostEvent]]:
    """Answer each request with this burst until the link is settled; return the time and the events."""
    events: list[HostEvent] = []
    while not link.is_settled:
        if REQUEST in link.data_to_send():
            events += link.receive_data(burst, now_s + 0.01)
        due_s = link.get_timer()
        assert due_s is not None
        now_s = due_s
        events += link.handle_timer(now_s)
    link.data_to_send()
    return now_s, events


def only(events: list[HostEvent], *kinds: type) -> list[HostEvent]:
    return [event for event in events if isinstance(event, kinds)]


class TestNegotiation:
    def test_a_small_board_is_known_after_two_short_bursts(self) -> None:
        device, publisher, subscriber = small_device()
        line = line_to(device)
        assert line.run_until(lambda: line.host.is_settled, 0.3)
        assert [
            type(event) for event in line.events_of(ProtocolDetected, TopicAnnounced, NegotiationSettled)
        ] == [
            ProtocolDetected,
            TopicAnnounced,
            TopicAnnounced,
            NegotiationSettled,
        ]
        settled = line.events_of(NegotiationSettled)[0]
        assert isinstance(settled, NegotiationSettled)
        assert (settled.topic_count, settled.service_count, settled.rounds) == (2, 0, 2)
        assert line.host.statistics.topic_requests == 2
        assert line.host.can_send(subscriber)
        assert not line.host.can_send(publisher)

    @pytest.mark.parametrize(("baud", "seeds"), [(float("inf"), 300), (1e6, 100)])
    def test_fifty_topics_and_services_on_a_line_that_loses_one_frame_in_twenty(
        self, baud: float, seeds: int
    ) -> None:
        late = []
        for seed in range(seeds):
            rng = random.Random(seed)
            device = DeviceLink(DeviceLinkConfig(max_publishers=29, max_subscribers=29))
            declare_many(device, 25, 25, 2)
            harm = lose_or_damage(rng, 0.05)
            line = line_to(device, baud=baud, to_host=harm, to_device=harm)
            host = line.host

            def is_complete(host: HostLink = host) -> bool:
                return (host._table.topic_count, host._table.service_count) == (50, 4)

            if not line.run_until(is_complete, 2.0):
                late.append(seed)
            assert line.run_until(lambda host=host: host.is_settled, 3.0)  # type: ignore[misc]
            assert is_complete(), f"seed {seed}: believed complete, but is not"
        assert not late

    def test_a_configured_board_is_found_by_a_host_that_restarts_on_a_lossy_line(self) -> None:
        for seed in range(100):
            rng = random.Random(seed)
            device = DeviceLink()
            declare_many(device, 5, 5, 0)
            device.start(0.0)
            device.receive_data(REQUEST, 0.0)
            device.data_to_send()
            harm = lose_or_damage(rng, 0.05)
            line = Line(HostLink(), device, to_host=harm, to_device=harm)
            line.host.start(line.now_s)
            line.flush()
            host = line.host
            assert line.run_until(lambda host=host: len(host._table) == 10, 2.0), seed  # type: ignore[misc]

    def test_a_slow_line_is_given_the_time_its_burst_takes(self) -> None:
        device = DeviceLink()
        declare_many(device, 25, 25, 0)
        line = line_to(device, baud=57600)
        line.run_until(lambda: line.host.is_settled, 4.0)
        assert line.host.statistics.topic_requests == 2

    @pytest.mark.parametrize("spin_period_s", [0.5, 1.0])
    def test_a_sketch_that_spins_rarely_is_not_flooded_with_requests(self, spin_period_s: float) -> None:
        device, _, _ = small_device()
        line = line_to(device, spin_period_s=spin_period_s)
        assert line.run_until(lambda: line.host.is_settled, 6 * spin_period_s)
        asked = line.host.statistics.topic_requests
        assert asked <= 8
        line.run(10.0)
        assert line.host.statistics.topic_requests == asked
        assert not line.events_of(DeviceReset, DeviceSilent)

    def test_a_board_that_boots_late_is_found_within_a_second(self) -> None:
        device, _, _ = small_device()
        line = line_to(device, device_is_on=False)
        line.run(7.3)
        line.device_is_on = True
        line.reset_device()
        assert line.run_until(lambda: bool(line.events_of(TopicAnnounced)), 1.1)

    def test_a_topic_declared_late_is_announced_and_confirmed(self) -> None:
        device, _, _ = small_device()
        line = line_to(device)
        assert line.run_until(lambda: line.host.is_settled, 1.0)
        late = device.add_subscriber("late", EMPTY, EMPTY_MD5)
        line.flush()
        line.run(1.0)
        assert line.host.can_send(late)
        assert line.host.is_settled
        assert line.host.statistics.topic_requests == 4
        assert not line.events_of(TopicWithdrawn)

    def test_version_1_is_found_after_a_version_2_request(self) -> None:
        device, publisher, subscriber = small_device(version=1)
        line = line_to(device)
        assert line.run_until(lambda: line.host.is_settled, 1.5)
        assert line.host.version == 1
        assert line.host.encode_message(subscriber, b"") == frame(subscriber, b"", 1)
        device.publish(publisher, [b"\x02\0\0\0hi"])
        line.flush()
        line.run(0.1)
        assert line.events_of(MessagesReceived) == [MessagesReceived(publisher, [b"\x02\0\0\0hi"])]

    def test_both_versions_requests_survive_in_a_sketch_that_reads_them_at_once(self) -> None:
        link = HostLink()
        link.start(0.0)
        data = link.data_to_send()
        while len(data) < 60:
            due_s = link.get_timer()
            assert due_s is not None
            link.handle_timer(due_s)
            data += link.data_to_send()
        for version in (1, 2):
            device, _, _ = small_device(version)
            device.receive_data(data, 0.0)
            assert device.is_configured

    def test_unknown_ids_lead_to_a_new_request_at_once_but_not_to_a_flood(self) -> None:
        link, now_s = settled_link()
        events = link.receive_data(frame(126, b"\0\0\0\0") * 3, now_s)
        assert events == [UnknownTopicId(126, 3)]
        assert link.data_to_send() == REQUEST
        asked = 0
        for tick in range(1000):
            now_s += 0.01
            link.receive_data(frame(126, b"\0\0\0\0"), now_s)
            if tick % 10 == 0:
                link.receive_data(TIME, now_s)
            link.handle_timer(now_s)
            if REQUEST in link.data_to_send():
                asked += 1
                link.receive_data(BURST, now_s)
        assert asked < 30

    def test_damaged_announcements_are_not_believed_and_asked_for_again(self) -> None:
        link = HostLink()
        link.start(0.0)
        link.data_to_send()
        bad = bytearray(LED.encode())
        bad[10] ^= 0xFF
        bad[11] ^= 0x01
        events = link.receive_data(
            TIME + frame(ids.PUBLISHER, CHATTER.encode()) + frame(ids.SUBSCRIBER, bytes(bad)), 0.0
        )
        assert [event.reason for event in events if isinstance(event, FrameDiscarded)] == [
            DiscardReason.PACKET
        ]
        assert not link.can_send(100)
        link.handle_timer(0.2)
        assert link.data_to_send() == REQUEST

    @pytest.mark.parametrize(
        "wrong", [{"topic_name": "left-wheel"}, {"message_type": "String"}, {"buffer_size": -5}]
    )
    def test_what_cannot_be_bridged_is_said_once_and_not_asked_for_again(self, wrong: dict[str, Any]) -> None:
        bad = replace(CHATTER, topic_id=126, **wrong)
        burst = BURST + frame(ids.PUBLISHER, bad.encode())
        link, now_s, events = settle_on(burst)
        assert link.statistics.topic_requests == 2
        (refused,) = only(events, AnnouncementRefused)
        assert isinstance(refused, AnnouncementRefused)
        assert (refused.topic_name, refused.message_type) == (bad.topic_name, bad.message_type)
        assert link.statistics.damaged_frames == 0
        assert link.receive_data(frame(126, b"\0\0\0\0"), now_s) == []
        link.receive_data(frame(130, b""), now_s)
        assert not only(run_to_settled(link, now_s, burst)[1], AnnouncementRefused)

    def test_a_refused_announcement_that_came_once_is_noise(self) -> None:
        link, now_s = settled_link()
        bad = replace(LED, topic_name="l-d")
        link.receive_data(TIME + frame(ids.SUBSCRIBER, bad.encode()), now_s)
        _, events = run_to_settled(link, now_s, BURST)
        assert not only(events, AnnouncementRefused, TopicWithdrawn)
        assert link.can_send(100)

    def test_a_topic_that_is_renamed_to_what_cannot_be_bridged_is_withdrawn(self) -> None:
        link, now_s = settled_link()
        link.receive_data(frame(130, b""), now_s)
        burst = TIME + frame(ids.PUBLISHER, CHATTER.encode())
        burst += frame(ids.SUBSCRIBER, replace(LED, topic_name="l-d").encode())
        _, events = run_to_settled(link, now_s, burst)
        assert len(only(events, AnnouncementRefused)) == 1
        assert [event.info for event in events if isinstance(event, TopicWithdrawn)] == [LED]
        assert not link.can_send(100)

    def test_half_a_service_is_reported_when_its_other_half_is_certain_not_to_come(self) -> None:
        half = TopicInfo(126, "ask", TEST_SRV, TEST_RESPONSE_MD5, 280)
        burst = BURST + frame(ids.SERVICE_SERVER_RESPONSE, half.encode())
        link, now_s, events = settle_on(burst)
        (refused,) = only(events, AnnouncementRefused)
        assert isinstance(refused, AnnouncementRefused)
        assert "no request half" in refused.reason
        assert link.statistics.topic_requests == 4
        link.receive_data(frame(130, b""), now_s)
        assert not only(run_to_settled(link, now_s, burst)[1], AnnouncementRefused)

    def test_topics_that_are_gone_are_withdrawn_only_when_that_is_certain(self) -> None:
        link, now_s = settled_link()
        link.receive_data(frame(126, b""), now_s)
        rounds = 0
        withdrawn: list[HostEvent] = []
        while not withdrawn:
            assert rounds < 10
            if REQUEST in link.data_to_send():
                link.receive_data(TIME + frame(ids.SUBSCRIBER, LED.encode()), now_s)
                rounds += 1
            due_s = link.get_timer()
            assert due_s is not None
            now_s = due_s
            withdrawn = only(link.handle_timer(now_s), TopicWithdrawn)
        assert rounds == 4
        assert len(withdrawn) == 1

    def test_too_many_endpoints(self) -> None:
        link = HostLink(HostLinkConfig(max_endpoints=1))
        link.start(0.0)
        events = link.receive_data(BURST, 0.0)
        assert len(only(events, TopicAnnounced)) == 1
        assert [event.reason for event in events if isinstance(event, FrameDiscarded)] == [
            DiscardReason.TOO_MANY
        ]


class TestResetAndSilence:
    def test_a_reset_board_talks_again_well_within_two_seconds(self) -> None:
        for delay_s in (0.1, 0.9, 1.7, 2.6, 3.3):
            device, publisher, subscriber = small_device()
            line = line_to(device)
            assert line.run_until(lambda line=line: line.host.is_settled, 1.0)  # type: ignore[misc]
            for _ in range(round(delay_s * 10) + 10):
                device.publish(publisher, [b"\0\0\0\0"])
                line.flush()
                line.run(0.1)
            line.reset_device()
            reset_s = line.now_s
            assert line.run_until(lambda device=device: device.is_configured, 1.5)  # type: ignore[misc]
            assert line.run_until(lambda line=line: line.host.is_settled, 0.3)  # type: ignore[misc]
            assert line.now_s - reset_s < 1.5
            assert len(line.events_of(DeviceReset)) == 1
            assert not line.events_of(TopicWithdrawn)
            assert line.host.can_send(subscriber)

    def test_nothing_is_sent_to_a_reset_board_before_it_has_announced(self) -> None:
        link, now_s = settled_link()
        link.receive_data(frame(125, b"\0\0\0\0"), now_s)
        probed = link.handle_timer(now_s + 1.0)
        assert probed == []
        assert link.data_to_send() == b"\xff\x00"
        events = link.receive_data(TIME, now_s + 1.01)
        events += link.receive_data(TIME, now_s + 1.02)
        assert DeviceReset() in events
        assert REQUEST in link.data_to_send()
        assert not link.can_send(100)
        with pytest.raises(LocalProtocolError, match="does not listen on topic id 100 now"):
            link.encode_message(100, b"")
        link.receive_data(BURST, now_s + 1.03)
        assert link.encode_message(100, b"") == frame(100, b"")

    def test_a_healthy_board_that_only_listens_is_not_disturbed(self) -> None:
        device = DeviceLink()
        device.add_subscriber("led", EMPTY, EMPTY_MD5)
        line = line_to(device)
        line.run(60.0)
        assert line.host.statistics.topic_requests == 2
        assert not line.events_of(DeviceReset, DeviceSilent)
        assert line.host.statistics.probes < 200

    @pytest.mark.parametrize(("baud", "count"), [(57600, 25), (9600, 6), (9600, 20)])
    def test_a_healthy_board_on_a_slow_line_is_not_taken_for_reset(self, baud: float, count: int) -> None:
        device = DeviceLink()
        declare_many(device, count, count, 0)
        line = line_to(device, baud=baud)
        line.run(60.0)
        assert line.host.is_settled
        assert line.host.statistics.topic_requests == 2
        assert not line.events_of(DeviceReset, DeviceSilent)

    def test_a_board_on_a_slow_line_that_is_reset_is_found(self) -> None:
        device = DeviceLink()
        declare_many(device, 20, 20, 0)
        line = line_to(device, baud=57600)
        line.run_until(lambda: line.host.is_settled, 5.0)
        line.reset_device()
        assert line.run_until(lambda: device.is_configured, 1.5)

    def test_a_board_that_logs_but_publishes_nothing_after_its_reset(self) -> None:
        device, _, _ = small_device()
        line = line_to(device)
        line.run_until(lambda: line.host.is_settled, 1.0)
        line.reset_device()
        for _ in range(15):
            device.log(LogLevel.INFO, "alive")
            line.flush()
            line.run(0.1)
        assert device.is_configured

    def test_silence_is_reported_once_and_the_device_is_searched(self) -> None:
        device, _, _ = small_device()
        line = line_to(device)
        line.run_until(lambda: line.host.is_settled, 1.0)
        line.device_is_on = False
        line.run(20.0)
        (silent,) = line.events_of(DeviceSilent)
        assert isinstance(silent, DeviceSilent)
        assert silent.silence_s == pytest.approx(4.0, abs=0.1)
        line.device_is_on = True
        line.reset_device()
        assert line.run_until(lambda: line.host.is_settled, 1.3)
        assert not line.events_of(TopicWithdrawn)
        assert len(line.events_of(ProtocolDetected)) == 1

    def test_a_version_1_board_is_asked_when_it_misses_its_time_request(self) -> None:
        device, _, _ = small_device(version=1)
        line = line_to(device)
        line.run_until(lambda: line.host.is_settled, 2.0)
        line.run(1.0)
        line.reset_device()
        assert line.run_until(lambda: line.host.statistics.negotiations == 2, 3.5)
        assert not line.events_of(DeviceSilent)

    def test_a_lost_time_request_is_no_silence(self) -> None:
        device, _, _ = small_device()
        line = line_to(device)
        line.run_until(lambda: line.host.is_settled, 1.0)
        line.to_host = lambda data: b""
        line.run(2.6)
        line.to_host = pass_unharmed
        line.run(2.0)
        assert not line.events_of(DeviceSilent, DeviceReset)

    def test_a_reset_in_the_middle_of_a_frame(self) -> None:
        link, now_s = settled_link()
        link.receive_data(frame(125, bytes(200))[:100], now_s)
        found: list[HostEvent] = []
        for _ in range(200):
            now_s += 0.01
            found += link.handle_timer(now_s)
            sent = link.data_to_send()
            if b"\xff\x00" in sent:
                found += link.receive_data(TIME, now_s)
            if REQUEST in sent:
                found += link.receive_data(BURST, now_s)
            found += link.handle_timer(now_s)
        assert DeviceReset() in found
        assert link.is_settled

    def test_without_answers_a_device_falls_silent_and_is_configured_again(self) -> None:
        device, publisher, _ = small_device()
        line = line_to(device, answers_time=False)
        line.run(11.5)
        assert line.run_until(lambda: device.is_configured, 1.5)
        assert device.publish(publisher, [b""])
        assert line.host.statistics.resets >= 1


class TestMessages:
    def test_batches_equal_single_frames(self) -> None:
        link, _ = settled_link()
        payloads = [bytes([number]) * number for number in range(100)]
        expected = b"".join(frame(100, payload) for payload in payloads)
        assert link.encode_messages(100, payloads) == expected
        assert link.encode_messages(100, []) == b""
        assert link.statistics.messages_sent == {100: 100}

    def test_never_more_than_the_buffer_nor_an_unknown_id(self) -> None:
        link, _ = settled_link()
        assert link.encode_message(100, bytes(150))
        with pytest.raises(
            LocalProtocolError, match="151 bytes does not fit the device's buffer of 150 bytes"
        ):
            link.encode_messages(100, [b"", bytes(151)])
        for topic_id in (125, 101, 7, 0):
            with pytest.raises(LocalProtocolError, match="does not listen"):
                link.encode_message(topic_id, b"")

    def test_messages_of_a_chunk_come_behind_its_announcements(self) -> None:
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
        with pytest.raises(LocalProtocolError, match="takes 212 bytes"):
            link.answer_parameter(ints=[1] * 50)
        link.answer_parameter(ints=[1] * 30)

    def test_time_is_answered_at_once(self) -> None:
        link, now_s = settled_link()
        assert TimeRequested() in link.receive_data(TIME, now_s)
        link.answer_time(Time(1700000000, 5), now_s)
        assert list(plain_decode(link.data_to_send())) == [(ids.TIME, bytes.fromhex("00f1536505000000"))]

    def test_time_waits_for_the_boards_own_call(self) -> None:
        link, now_s = settled_link()
        link.service_call_started(now_s)
        link.answer_time(Time(1700000000, 0), now_s)
        assert link.data_to_send() == b""
        response = link.encode_message(100, b"")
        link.service_call_finished(now_s + 0.5)
        assert response
        ((topic_id, payload),) = plain_decode(link.data_to_send())
        assert topic_id == ids.TIME
        assert decode_time(payload) == Time(1700000000, 500_000_000)

    def test_but_not_for_ever(self) -> None:
        link, now_s = settled_link()
        link.service_call_started(now_s)
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
        link.service_call_started(now_s)
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
        assert line.host.can_send(served.request_id)
        assert line.host.can_send(called.response_id)
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
    assert statistics.messages_received == {publisher: 7}
    assert statistics.bytes_received == len(line.sent_by_device)
    assert statistics.bytes_sent == len(line.sent_by_host)
    assert statistics.negotiations == 1
    assert statistics.time_requests == statistics.time_answers == 3
    assert statistics.last_round_trip_s == pytest.approx(0.01, abs=0.001)
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
