"""A device that floods control frames causes a bounded amount of work, and what matters gets through."""

from __future__ import annotations

from msgspec.structs import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.control_rate import CHANGES, LOGS, TIME_REQUESTS, ControlRate
from rostether.rosserial.events import (
    ControlFlood,
    LogReceived,
    MessagesReceived,
    TimeRequested,
    TopicAnnounced,
    TopicWithdrawn,
)
from rostether.rosserial.packets import Log, LogLevel, TopicInfo
from unit.rosserial.decoding import frame
from unit.rosserial.host_link_boards import TIME, only, settled_link

STRING = TopicInfo(126, "/flood", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", 512)


def announcement(number: int) -> bytes:
    return frame(ids.PUBLISHER, replace(STRING, topic_name=f"/flood{number}").encode())


class TestControlRate:
    def test_saves_no_more_than_a_burst(self) -> None:
        rate = ControlRate()
        assert rate.admit(ids.LOG, 10_000, 1e9) == LOGS.burst
        assert rate.admit(ids.LOG, 10_000, 1e9) == 0
        assert rate.admit(ids.LOG, 10_000, 1e9 + 0.5) == LOGS.per_s / 2

    def test_the_kinds_have_separate_limits(self) -> None:
        rate = ControlRate()
        rate.admit(ids.LOG, 10_000, 0.0)
        assert rate.admit(ids.TIME, 1, 0.0) == 1
        assert rate.admit(ids.PARAMETER, 1, 0.0) == 1
        assert rate.admit(ids.PUBLISHER, 1, 0.0) == 1

    def test_all_announcements_count_together(self) -> None:
        rate = ControlRate()
        rate.admit(ids.PUBLISHER, 100_000, 0.0)
        assert rate.admit(ids.SUBSCRIBER, 1, 0.0) == 0


class TestFloods:
    def test_log_lines_beyond_the_rate_are_counted(self) -> None:
        link, now_s = settled_link()
        flood = frame(ids.LOG, Log(LogLevel.INFO, "again").encode()) * (LOGS.burst + 100)
        events = link.receive_data(flood, now_s)
        assert len(only(events, LogReceived)) == LOGS.burst
        assert only(events, ControlFlood) == [ControlFlood(ids.LOG, 100)]

    def test_time_requests_are_answered_at_a_bounded_rate(self) -> None:
        link, now_s = settled_link()
        asked = 0
        for _ in range(100):
            now_s += 0.01
            asked += len(only(link.receive_data(TIME * 50, now_s), TimeRequested))
        assert TIME_REQUESTS.per_s <= asked <= TIME_REQUESTS.burst + 2 * TIME_REQUESTS.per_s

    def test_an_announcement_that_changes_repeatedly_is_dropped(self) -> None:
        link, now_s = settled_link()
        events = link.receive_data(b"".join(map(announcement, range(CHANGES.burst + 50))), now_s)
        assert len(only(events, TopicAnnounced)) == CHANGES.burst
        assert len(only(events, TopicWithdrawn)) <= CHANGES.burst
        assert only(events, ControlFlood) == [ControlFlood(ids.PUBLISHER, 50)]

    def test_announcements_that_change_nothing_do_not_use_up_changes(self) -> None:
        link, now_s = settled_link()
        link.receive_data(announcement(0) * (CHANGES.burst + 50), now_s)
        assert only(link.receive_data(announcement(1), now_s), TopicAnnounced)

    def test_messages_flow_on(self) -> None:
        link, now_s = settled_link()
        link.receive_data(announcement(0), now_s)
        flood = frame(ids.LOG, Log(LogLevel.INFO, "again").encode()) * (2 * LOGS.burst)
        events = link.receive_data(flood + frame(126, b"\0\0\0\0") * 3, now_s)
        messages = [event for event in events if isinstance(event, MessagesReceived)]
        assert [event.payloads for event in messages] == [[b"\0\0\0\0"] * 3]
