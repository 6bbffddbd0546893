from __future__ import annotations

import itertools

from msgspec.structs import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.announcements import (
    FIRST_PAUSE_S,
    MAX_IDS,
    MAX_PAUSE_S,
    MAX_REFUSALS,
    Announcements,
    Refusals,
    UnknownIds,
)
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
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_table import EndpointKey, TopicTable, key_of
from unit.rosserial.host_link_boards import CHATTER
from unit.rosserial.sessions import STRING, STRING_MD5, TEST_RESPONSE_MD5, TEST_SRV

WHEEL = TopicInfo(125, "left-wheel", STRING, STRING_MD5, 280)
RESPONSE = TopicInfo(126, "ask", TEST_SRV, TEST_RESPONSE_MD5, 280)
REFUSED = [AnnouncementRefused("left-wheel", STRING, "why")]


def announcements(max_endpoints: int = 256) -> tuple[Announcements, TopicTable]:
    table = TopicTable(max_endpoints)
    return Announcements(table, ControlRate()), table


def test_a_new_topic_is_reported_once() -> None:
    known, table = announcements()
    new = [TopicAnnounced(TopicRole.PUBLISHER, CHATTER)]
    assert known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0) == (CHATTER, new)
    assert known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0) == (CHATTER, [])
    assert len(table.keys()) == 1


def test_damage_reveals_nothing_about_the_device() -> None:
    known, table = announcements()
    assert known.handle_packet(ids.PUBLISHER, b"?", 0.0) == (
        None,
        [FrameDiscarded(DiscardReason.PACKET, b"?", ids.PUBLISHER)],
    )
    assert len(table.keys()) == 0


def test_a_refused_announcement_counts_but_is_not_bridged() -> None:
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
    for number in range(CHANGES.burst - 2):
        known.handle_packet(ids.PUBLISHER, replace(CHATTER, topic_name=f"n{number}").encode(), 0.0)
    assert known.handle_packet(ids.PUBLISHER, other.encode(), 0.0) == (None, [ControlFlood(ids.PUBLISHER, 1)])


def test_a_negotiation_keeps_the_endpoints_that_it_found() -> None:
    known, table = announcements()
    known.handle_packet(ids.PUBLISHER, CHATTER.encode(), 0.0)
    assert known.withdraw_all_but({key_of(ids.PUBLISHER, CHATTER)}) == []
    assert known.withdraw_all_but(()) == [TopicWithdrawn(TopicRole.PUBLISHER, CHATTER)]
    assert len(table.keys()) == 0


def test_asks_immediately_then_less_and_less_often() -> None:
    unknown = UnknownIds()
    asked = [second for second in range(1000) if unknown.should_ask(130, float(second))]
    assert asked[:5] == [0, 1, 3, 7, 15]
    assert max(later - earlier for earlier, later in itertools.pairwise(asked)) == MAX_PAUSE_S


def test_each_id_for_itself() -> None:
    unknown = UnknownIds()
    assert unknown.should_ask(130, 0.0)
    assert unknown.should_ask(131, 0.0)
    assert not unknown.should_ask(130, FIRST_PAUSE_S / 2)


def test_an_announced_id_starts_again() -> None:
    unknown = UnknownIds()
    unknown.should_ask(130, 0.0)
    unknown.forget(130)
    assert unknown.should_ask(130, 0.1)


def test_memory_is_bounded() -> None:
    unknown = UnknownIds()
    for topic_id in range(100, 100 + 3 * MAX_IDS):
        unknown.should_ask(topic_id, 0.0)
    assert len(unknown._pauses) == MAX_IDS


def test_one_refused_announcement_may_be_noise() -> None:
    refusals = Refusals()
    assert refusals.refuse(ids.PUBLISHER, WHEEL, "why") == []
    assert refusals.refuse(ids.PUBLISHER, replace(WHEEL, topic_name="left-whee-"), "why") == []
    assert not refusals.is_sender(125)


def test_a_repeated_refused_announcement_is_reported_once() -> None:
    refusals = Refusals()
    found = [refusals.refuse(ids.PUBLISHER, WHEEL, "why") for _ in range(5)]
    assert found == [[], REFUSED, [], [], []]
    assert refusals.is_sender(125)
    assert not refusals.is_sender(126)
    assert refusals.keys == {EndpointKey(True, 125)}


def test_each_direction_is_reported() -> None:
    refusals = Refusals()
    for kind in (ids.PUBLISHER, ids.SUBSCRIBER):
        refusals.refuse(kind, WHEEL, "why")
        assert refusals.refuse(kind, WHEEL, "why") == REFUSED


def test_an_endpoint_that_is_announced_correctly_is_no_longer_refused() -> None:
    refusals = Refusals()
    for _ in range(2):
        refusals.refuse(ids.PUBLISHER, WHEEL, "why")
    refusals.forget(ids.PUBLISHER, replace(WHEEL, topic_name="left_wheel"))
    assert not refusals.is_sender(125)
    assert refusals.refuse(ids.PUBLISHER, WHEEL, "why") == []
    assert refusals.is_sender(125)


def test_an_incomplete_service_is_reported_once_with_the_missing_part() -> None:
    refusals = Refusals()
    (event,) = refusals.refuse_incomplete_services([(ids.SERVICE_SERVER_RESPONSE, RESPONSE)])
    assert (event.topic_name, event.message_type) == ("ask", TEST_SRV)
    assert "server announces its response, but no request of" in event.reason
    assert refusals.refuse_incomplete_services([(ids.SERVICE_SERVER_RESPONSE, RESPONSE)]) == []
    (event,) = refusals.refuse_incomplete_services([(ids.SERVICE_CLIENT_REQUEST, RESPONSE)])
    assert "client announces its request, but no response of" in event.reason


def test_invented_names_do_not_fill_the_memory_and_are_reported_to_a_limit() -> None:
    refusals = Refusals()
    reported = 0
    for number in range(3 * MAX_REFUSALS):
        info = replace(WHEEL, topic_id=1000 + number)
        refusals.refuse(ids.PUBLISHER, info, "why")
        reported += len(refusals.refuse(ids.PUBLISHER, info, "why"))
        refusals.refuse(ids.SUBSCRIBER, info, "why")
    assert reported == MAX_REFUSALS
    assert len(refusals.keys) == MAX_REFUSALS
    assert len(refusals._once) == MAX_REFUSALS
