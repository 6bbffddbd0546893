from __future__ import annotations

import pytest

from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.line_watch import LineWatch
from rostether.bridge.findings.medium import Medium
from rostether.bridge.findings.resets import Resets
from rostether.rosserial.events import (
    DiscardReason,
    FrameDiscarded,
    ProtocolDetected,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
    UnknownTopicId,
)
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.rosserial.packets import TopicInfo

LED = TopicAnnounced(TopicRole.SUBSCRIBER, TopicInfo(100, "led", "std_msgs/Bool", "", 512))


def codes(checked_s: set[int]) -> set[Code]:
    watch = LineWatch(None, Resets(), LinkStatistics(), 0.0)
    found: set[Code] = set()
    for second in range(20):
        if second in checked_s:
            found |= {each.code for each in watch.find(float(second))}
        if second in (4, 7, 16):
            watch.handle_event(TimeRequested(), float(second))
    return found


def test_requests_that_waited_while_this_process_was_paused_are_not_late() -> None:
    running, paused = set(range(20)), set(range(8, 16))
    assert Code.SLOW_LOOP in codes(running)
    assert Code.SLOW_LOOP not in codes(running - paused)


def test_a_network_that_delays_requests_is_not_a_slow_loop() -> None:
    for baud, medium in ((57600, Medium.SERIAL), (None, Medium.SERIAL), (None, Medium.TCP)):
        watch = LineWatch(baud, Resets(), LinkStatistics(), 0.0, medium=medium)
        watch.handle_event(LED, 0.0)
        for number in range(4):
            watch.handle_event(TimeRequested(), number * 2.8)
        assert [each.code for each in watch.find(2.0)] == (
            [Code.SLOW_LOOP] if medium is Medium.SERIAL else []
        )


def test_the_rest_of_a_long_message_is_text_of_the_sketch_only_where_no_datagram_is_lost() -> None:
    for medium, code in ((Medium.TCP, Code.TEXT_BETWEEN_FRAMES), (Medium.UDP, Code.FRAMES_DAMAGED)):
        statistics = LinkStatistics()
        watch = LineWatch(None, Resets(), statistics, 0.0, medium=medium)
        watch.handle_event(ProtocolDetected(2), 0.0)
        watch.find(0.0)
        for number in range(1, 6):
            watch.handle_event(FrameDiscarded(DiscardReason.NOISE, b"y" * 200), float(number))
            statistics.frames_received += 1
        assert [each.code for each in watch.find(6.0)] == [code]


@pytest.mark.parametrize(
    ("medium", "advice"),
    [
        (Medium.TCP, "shielded cable"),
        (Medium.UDP, "loses datagrams"),
        (Medium.RADIO, "move the radios closer"),
    ],
)
def test_the_advice_for_damaged_frames_is_that_of_the_line(medium: Medium, advice: str) -> None:
    statistics = LinkStatistics()
    watch = LineWatch(None, Resets(), statistics, 0.0, medium=medium)
    watch.handle_event(ProtocolDetected(2), 0.0)
    watch.find(0.0)
    for number in range(1, 6):
        watch.handle_event(
            FrameDiscarded(DiscardReason.PAYLOAD_CHECKSUM, b"\xff\xfe\x05\x00\xfa"), float(number)
        )
        statistics.frames_received += 1
    (finding,) = watch.find(6.0)
    assert advice in finding.next_step


@pytest.mark.parametrize("is_damaged", [False, True])
def test_a_time_request_that_is_lost_in_noise_is_not_a_slow_loop(is_damaged: bool) -> None:
    watch = LineWatch(57600, Resets(), LinkStatistics(), 0.0)
    watch.handle_event(LED, 0.0)
    watch.handle_event(ProtocolDetected(2), 0.0)
    for number in range(6):
        watch.handle_event(TimeRequested(), number * 5.0)
        if is_damaged:
            damage = FrameDiscarded(DiscardReason.PAYLOAD_CHECKSUM, b"\xff\xfe\x08\x00\xf7\x0a")
            watch.handle_event(damage, number * 5.0 + 2.5)
    assert (Code.SLOW_LOOP in {each.code for each in watch.find(26.0)}) is not is_damaged


def test_a_sketch_that_prints_short_texts_and_sleeps_has_a_slow_loop() -> None:
    watch = LineWatch(57600, Resets(), LinkStatistics(), 0.0)
    watch.handle_event(LED, 0.0)
    watch.handle_event(ProtocolDetected(2), 0.0)
    for number in range(6):
        watch.handle_event(TimeRequested(), number * 4.0)
        watch.handle_event(FrameDiscarded(DiscardReason.NOISE, b"42\n"), number * 4.0 + 2.0)
    assert {each.code for each in watch.find(22.0)} >= {Code.SLOW_LOOP}


def test_unannounced_messages_are_found_if_an_id_repeats() -> None:
    watch = LineWatch(57600, Resets(), LinkStatistics(), 0.0)
    watch.handle_event(ProtocolDetected(2), 0.0)
    for number in range(300):
        watch.handle_event(UnknownTopicId(1000 + number), 1.0)
    assert watch.find(20.0) == []
    watch = LineWatch(57600, Resets(), LinkStatistics(), 0.0)
    watch.handle_event(ProtocolDetected(2), 0.0)
    for topic_id in (130, 131, 130, 131):
        watch.handle_event(UnknownTopicId(topic_id), 1.0)
    assert watch.find(9.0) == []
    (finding,) = watch.find(12.0)
    assert finding.seen == "2 messages have topic id 130, which the board never announces"
    # The announcement of 130 was only late.
    late = TopicInfo(130, "chatter", "std_msgs/String", "", 512)
    watch.handle_event(TopicAnnounced(TopicRole.PUBLISHER, late), 12.0)
    (finding,) = watch.find(13.0)
    assert finding.seen == "2 messages have topic id 131, which the board never announces"
