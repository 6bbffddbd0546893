"""Resets, silence and the signs of life."""

from __future__ import annotations

import pytest

from rostether.errors import LocalProtocolError
from rostether.rosserial.device_link import DeviceLink
from rostether.rosserial.events import (
    DeviceReset,
    DeviceSilent,
    HostEvent,
    NegotiationSettled,
    ProtocolDetected,
    TopicWithdrawn,
)
from rostether.rosserial.host_output import PROBE
from rostether.rosserial.packets import LogLevel
from unit.rosserial.decoding import can_send, frame
from unit.rosserial.host_link_boards import (
    BURST,
    REQUEST,
    TIME,
    line_to,
    run_to_settled,
    settled_link,
    small_device,
)
from unit.rosserial.sessions import (
    EMPTY,
    EMPTY_MD5,
    declare_many,
    pass_unharmed,
)


class TestResetAndSilence:
    def test_a_reset_board_sends_messages_again_within_two_seconds(self) -> None:
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
            assert can_send(line.host, subscriber)

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
        assert not can_send(link, 100)
        with pytest.raises(LocalProtocolError, match="has not announced a subscriber with topic id 100;"):
            link.encode_message(100, b"")
        link.receive_data(BURST, now_s + 1.03)
        assert link.encode_message(100, b"") == frame(100, b"")

    @pytest.mark.parametrize("pause_s", [0.0, 0.3])
    def test_a_board_that_introduces_itself_again_was_reset(self, pause_s: float) -> None:
        """Our library does so, and needs no question: announcements first, then the time request."""
        link, now_s = settled_link()
        for reset in (1, 2):
            now_s += 2.2
            events = link.receive_data(BURST[len(TIME) :], now_s)
            assert events == []
            events = link.receive_data(TIME, now_s + pause_s)
            assert DeviceReset() in events
            assert link.statistics.resets == reset
            assert not can_send(link, 100)
            now_s, _ = run_to_settled(link, now_s + pause_s, BURST)
            assert can_send(link, 100)

    def test_a_repeated_answer_is_not_a_reset(self) -> None:
        link, now_s = settled_link()
        events = link.receive_data(BURST, now_s + 0.5)
        events += link.receive_data(TIME, now_s + 2.5)
        assert DeviceReset() not in events

    def test_a_healthy_board_that_only_listens_is_not_disturbed(self) -> None:
        device = DeviceLink()
        device.add_subscriber("led", EMPTY, EMPTY_MD5)
        line = line_to(device)
        line.run(60.0)
        assert line.host.statistics.topic_requests == 2
        assert not line.events_of(DeviceReset, DeviceSilent)
        assert bytes(line.sent_by_host).count(PROBE) < 200

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
        assert line.run_until(lambda: len(line.events_of(NegotiationSettled)) == 2, 3.5)
        assert not line.events_of(DeviceSilent)

    def test_a_lost_time_request_is_not_silence(self) -> None:
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

    def test_a_device_without_answers_stops_sending_and_is_configured_again(self) -> None:
        device, publisher, _ = small_device()
        line = line_to(device, answers_time=False)
        line.run(11.5)
        assert line.run_until(lambda: device.is_configured, 1.5)
        assert device.publish(publisher, [b""])
        assert line.host.statistics.resets >= 1
