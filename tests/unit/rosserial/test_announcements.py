from __future__ import annotations

from dataclasses import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.announcements import Announcements
from rostether.rosserial.control_rate import CHANGES, ControlRate
from rostether.rosserial.events import (
    AnnouncementRefused,
    ControlFlood,
    DiscardReason,
    FrameDiscarded,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from rostether.rosserial.topic_table import TopicTable, key_of
from unit.rosserial.host_link_boards import CHATTER


def announcements(max_endpoints: int = 256) -> tuple[Announcements, TopicTable]:
    table = TopicTable(max_endpoints)
    return Announcements(table, ControlRate()), table


def test_what_is_new_is_reported_once() -> None:
    known, table = announcements()
    new = [TopicAnnounced(TopicRole.PUBLISHER, CHATTER)]
    assert known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0) == (CHATTER, new)
    assert known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0) == (CHATTER, [])
    assert len(table) == 1


def test_damage_reveals_nothing_about_the_device() -> None:
    known, table = announcements()
    assert known.handle_packet(ids.PUBLISHER, b"?", 0.0) == (
        None,
        [FrameDiscarded(DiscardReason.PACKET, b"?")],
    )
    assert len(table) == 0


def test_what_is_refused_is_there_all_the_same_and_not_bridged() -> None:
    known, _ = announcements()
    bad = replace(CHATTER, message_type="no type")
    info, _ = known.handle_packet(ids.PUBLISHER, bad.encode(), 0.0)
    assert info == bad
    _, events = known.handle_packet(ids.PUBLISHER, bad.encode(), 0.0)
    assert isinstance(events[1], AnnouncementRefused)
    assert known.is_refused_sender(bad.topic_id)
    known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0)
    assert not known.is_refused_sender(bad.topic_id)


def test_too_many_and_too_often_are_not_taken() -> None:
    known, _ = announcements(max_endpoints=1)
    known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0)
    other = replace(CHATTER, topic_id=126)
    assert known.handle_packet(ids.PUBLISHER, other.encode(), 0.0) == (
        None,
        [FrameDiscarded(DiscardReason.TOO_MANY, other.encode())],
    )
    for number in range(CHANGES.saved - 2):
        known.handle_packet(ids.PUBLISHER, replace(CHATTER, topic_name=f"n{number}").encode(), 0.0)
    assert known.handle_packet(ids.PUBLISHER, other.encode(), 0.0) == (None, [ControlFlood(ids.PUBLISHER, 1)])


def test_a_negotiation_leaves_what_it_found() -> None:
    known, table = announcements()
    known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0)
    assert known.withdraw_all_but({key_of(ids.PUBLISHER, CHATTER)}) == []
    assert known.withdraw_all_but(()) == [TopicWithdrawn(TopicRole.PUBLISHER, CHATTER)]
    assert len(table) == 0
