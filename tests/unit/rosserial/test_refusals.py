from __future__ import annotations

from dataclasses import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import AnnouncementRefused
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.refusals import MAX_REFUSALS, Refusals
from rostether.rosserial.topic_table import EndpointKey
from unit.rosserial.sessions import STRING, STRING_MD5, TEST_RESPONSE_MD5, TEST_SRV

WHEEL = TopicInfo(125, "left-wheel", STRING, STRING_MD5, 280)
RESPONSE = TopicInfo(126, "ask", TEST_SRV, TEST_RESPONSE_MD5, 280)
REFUSED = [AnnouncementRefused("left-wheel", STRING, "why")]


def test_what_came_once_may_be_noise() -> None:
    refusals = Refusals()
    assert refusals.refuse(ids.PUBLISHER, WHEEL, "why") == []
    assert refusals.refuse(ids.PUBLISHER, replace(WHEEL, topic_name="left-whee-"), "why") == []
    assert not refusals.is_sender(125)


def test_what_came_twice_is_reported_once() -> None:
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


def test_an_endpoint_that_is_announced_well_is_refused_no_longer() -> None:
    refusals = Refusals()
    for _ in range(2):
        refusals.refuse(ids.PUBLISHER, WHEEL, "why")
    refusals.forget(ids.PUBLISHER, replace(WHEEL, topic_name="left_wheel"))
    assert not refusals.is_sender(125)
    assert refusals.refuse(ids.PUBLISHER, WHEEL, "why") == []
    assert refusals.is_sender(125)


def test_the_half_of_a_service_is_reported_once_with_what_is_missing() -> None:
    refusals = Refusals()
    (event,) = refusals.refuse_lone_halves([(ids.SERVICE_SERVER_RESPONSE, RESPONSE)])
    assert (event.topic_name, event.message_type) == ("ask", TEST_SRV)
    assert "server announces its response half, but no request half" in event.reason
    assert refusals.refuse_lone_halves([(ids.SERVICE_SERVER_RESPONSE, RESPONSE)]) == []
    (event,) = refusals.refuse_lone_halves([(ids.SERVICE_CLIENT_REQUEST, RESPONSE)])
    assert "client announces its request half, but no response half" in event.reason


def test_endless_inventions_fill_no_memory_and_are_not_reported_for_ever() -> None:
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
