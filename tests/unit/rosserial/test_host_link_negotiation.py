"""Asking for topics until the set is known."""

from __future__ import annotations

import random
from typing import Any

import pytest
from msgspec.structs import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_link import DeviceLink, DeviceLinkConfig
from rostether.rosserial.events import (
    AnnouncementRefused,
    DeviceReset,
    DeviceSilent,
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    MessagesReceived,
    NegotiationSettled,
    ProtocolDetected,
    TopicAnnounced,
    TopicWithdrawn,
    UnknownTopicId,
)
from rostether.rosserial.host_link import HostLink, HostLinkConfig
from rostether.rosserial.packets import TopicInfo
from unit.rosserial.decoding import can_send, frame
from unit.rosserial.host_link_boards import (
    BURST,
    CHATTER,
    LED,
    REQUEST,
    TIME,
    line_to,
    only,
    run_to_settled,
    settle_on,
    settled_link,
    small_device,
)
from unit.rosserial.sessions import (
    EMPTY,
    EMPTY_MD5,
    TEST_RESPONSE_MD5,
    TEST_SRV,
    Line,
    declare_many,
    lose_or_damage,
)


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
        assert line.host.statistics.topic_requests == 2
        assert can_send(line.host, subscriber)
        assert not can_send(line.host, publisher)

    @pytest.mark.parametrize(("baud", "seeds"), [(float("inf"), 100), (1e6, 50)])
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
                return len(host._table.keys()) == 50 + 2 * 4 and not host._table.incomplete_services()

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
            assert line.run_until(lambda host=host: len(host._table.keys()) == 10, 2.0), seed  # type: ignore[misc]

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
        assert can_send(line.host, late)
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

    def test_a_sketch_that_reads_requests_of_both_versions_together_answers(self) -> None:
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

    def test_unknown_ids_cause_one_request_immediately_and_few_later(self) -> None:
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
        assert not can_send(link, 100)
        link.handle_timer(0.2)
        assert link.data_to_send() == REQUEST

    @pytest.mark.parametrize(
        "wrong", [{"topic_name": "left-wheel"}, {"message_type": "String"}, {"buffer_size": -5}]
    )
    def test_a_refused_topic_is_reported_once_and_not_requested_again(self, wrong: dict[str, Any]) -> None:
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
        assert can_send(link, 100)

    def test_a_topic_that_gets_an_invalid_name_is_withdrawn(self) -> None:
        link, now_s = settled_link()
        link.receive_data(frame(130, b""), now_s)
        burst = TIME + frame(ids.PUBLISHER, CHATTER.encode())
        burst += frame(ids.SUBSCRIBER, replace(LED, topic_name="l-d").encode())
        _, events = run_to_settled(link, now_s, burst)
        assert len(only(events, AnnouncementRefused)) == 1
        assert [event.info for event in events if isinstance(event, TopicWithdrawn)] == [LED]
        assert not can_send(link, 100)

    def test_an_incomplete_service_is_reported_when_the_topics_are_confirmed(self) -> None:
        half = TopicInfo(126, "ask", TEST_SRV, TEST_RESPONSE_MD5, 280)
        burst = BURST + frame(ids.SERVICE_SERVER_RESPONSE, half.encode())
        link, now_s, events = settle_on(burst)
        (refused,) = only(events, AnnouncementRefused)
        assert isinstance(refused, AnnouncementRefused)
        assert "no request of" in refused.reason
        assert link.statistics.topic_requests == 4
        link.receive_data(frame(130, b""), now_s)
        assert not only(run_to_settled(link, now_s, burst)[1], AnnouncementRefused)

    def test_removed_topics_are_withdrawn_only_when_that_is_certain(self) -> None:
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
