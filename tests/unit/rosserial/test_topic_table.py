from __future__ import annotations

import random

from msgspec.structs import replace

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import (
    ServiceAnnounced,
    ServiceRole,
    ServiceWithdrawn,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
)
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_table import CONTROL_LIMITS, EndpointKey, TopicTable
from unit.rosserial.sessions import (
    EMPTY,
    EMPTY_MD5,
    STRING,
    STRING_MD5,
    TEST_REQUEST_MD5,
    TEST_RESPONSE_MD5,
    TEST_SRV,
)

CHATTER = TopicInfo(125, "chatter", STRING, STRING_MD5, 280)
LED = TopicInfo(100, "led", EMPTY, EMPTY_MD5, 150)
REQUEST = TopicInfo(101, "ask", TEST_SRV, TEST_REQUEST_MD5, 280)
RESPONSE = TopicInfo(126, "ask", TEST_SRV, TEST_RESPONSE_MD5, 280)


def test_topics_are_reported_once() -> None:
    table = TopicTable(10)
    assert table.announce(ids.PUBLISHER, CHATTER) == [TopicAnnounced(TopicRole.PUBLISHER, CHATTER)]
    assert table.announce(ids.SUBSCRIBER, LED) == [TopicAnnounced(TopicRole.SUBSCRIBER, LED)]
    assert table.announce(ids.PUBLISHER, CHATTER) == []
    assert table.keys() == {EndpointKey(True, CHATTER.topic_id), EndpointKey(False, LED.topic_id)}


def test_a_changed_topic_is_withdrawn_and_announced() -> None:
    table = TopicTable(10)
    table.announce(ids.PUBLISHER, CHATTER)
    other = replace(CHATTER, topic_name="talk")
    assert table.announce(ids.PUBLISHER, other) == [
        TopicWithdrawn(TopicRole.PUBLISHER, CHATTER),
        TopicAnnounced(TopicRole.PUBLISHER, other),
    ]


def test_one_id_for_both_directions_is_two_endpoints() -> None:
    table = TopicTable(10)
    table.announce(ids.PUBLISHER, CHATTER)
    table.announce(ids.SUBSCRIBER, replace(LED, topic_id=125))
    assert table.keys() == {EndpointKey(True, 125), EndpointKey(False, 125)}


def test_one_name_for_both_directions_is_two_topics() -> None:
    table = TopicTable(10)
    table.announce(ids.PUBLISHER, CHATTER)
    assert table.announce(ids.SUBSCRIBER, replace(CHATTER, topic_id=100)) != []


def test_services_are_reported_when_request_and_response_are_known() -> None:
    for first, second in (
        ((ids.SERVICE_SERVER_RESPONSE, RESPONSE), (ids.SERVICE_SERVER_REQUEST, REQUEST)),
        ((ids.SERVICE_SERVER_REQUEST, REQUEST), (ids.SERVICE_SERVER_RESPONSE, RESPONSE)),
    ):
        table = TopicTable(10)
        assert table.announce(*first) == []
        assert table.announce(*second) == [
            ServiceAnnounced(ServiceRole.SERVER, "ask", TEST_SRV, REQUEST, RESPONSE)
        ]
        assert table.incomplete_services() == []


def test_a_server_and_a_client_of_one_name_are_two_services() -> None:
    table = TopicTable(10)
    table.announce(ids.SERVICE_SERVER_RESPONSE, RESPONSE)
    table.announce(ids.SERVICE_SERVER_REQUEST, REQUEST)
    client_request, client_response = replace(REQUEST, topic_id=127), replace(RESPONSE, topic_id=102)
    assert table.announce(ids.SERVICE_CLIENT_REQUEST, client_request) == []
    assert table.announce(ids.SERVICE_CLIENT_RESPONSE, client_response) == [
        ServiceAnnounced(ServiceRole.CLIENT, "ask", TEST_SRV, client_request, client_response)
    ]


def test_a_service_loses_a_half() -> None:
    table = TopicTable(10)
    table.announce(ids.SERVICE_SERVER_RESPONSE, RESPONSE)
    table.announce(ids.SERVICE_SERVER_REQUEST, REQUEST)
    withdrawn = ServiceWithdrawn(ServiceRole.SERVER, "ask", TEST_SRV, REQUEST, RESPONSE)
    assert table.withdraw_all_but([EndpointKey(True, 126)]) == [withdrawn]


def test_services_without_request_or_response() -> None:
    table = TopicTable(10)
    table.announce(ids.PUBLISHER, CHATTER)
    table.announce(ids.SERVICE_SERVER_RESPONSE, RESPONSE)
    assert table.incomplete_services() == [(ids.SERVICE_SERVER_RESPONSE, RESPONSE)]
    other_type = replace(REQUEST, message_type="std_srvs/Empty")
    table.announce(ids.SERVICE_SERVER_REQUEST, other_type)
    assert len(table.incomplete_services()) == 2
    table.announce(ids.SERVICE_SERVER_REQUEST, REQUEST)
    assert table.incomplete_services() == []


def test_two_clients_of_one_service_pair_in_order() -> None:
    table = TopicTable(10)
    for number in (0, 1):
        table.announce(ids.SERVICE_CLIENT_REQUEST, replace(REQUEST, topic_id=125 + number))
        events = table.announce(ids.SERVICE_CLIENT_RESPONSE, replace(RESPONSE, topic_id=100 + number))
    announced = [event for event in events or [] if isinstance(event, ServiceAnnounced)]
    assert [(each.request.topic_id, each.response.topic_id) for each in announced] == [(125, 100), (126, 101)]


def test_remaining_ids_of_a_service_are_announced_before_the_others_are_withdrawn() -> None:
    table = TopicTable(10)
    for number in (1, 0):
        table.announce(ids.SERVICE_CLIENT_REQUEST, replace(REQUEST, topic_id=125 + number))
        table.announce(ids.SERVICE_CLIENT_RESPONSE, replace(RESPONSE, topic_id=100 + number))
    role = ServiceRole.CLIENT
    request, response = replace(REQUEST, topic_id=126), replace(RESPONSE, topic_id=101)
    assert table.withdraw_all_but([EndpointKey(True, 125), EndpointKey(False, 100)]) == [
        ServiceAnnounced(
            role, "ask", TEST_SRV, replace(REQUEST, topic_id=125), replace(RESPONSE, topic_id=100)
        ),
        ServiceWithdrawn(role, "ask", TEST_SRV, request, response),
    ]


def test_withdrawal() -> None:
    table = TopicTable(10)
    table.announce(ids.PUBLISHER, CHATTER)
    table.announce(ids.SUBSCRIBER, LED)
    assert table.withdraw_all_but([EndpointKey(False, 100)]) == [TopicWithdrawn(TopicRole.PUBLISHER, CHATTER)]
    assert table.withdraw_all_but([EndpointKey(False, 100)]) == []
    assert table.senders == set()


def test_limits_of_both_directions() -> None:
    table = TopicTable(10)
    table.announce(ids.PUBLISHER, CHATTER)
    table.announce(ids.SUBSCRIBER, LED)
    assert table.send_limits == {100: 150}
    assert table.limits.possible == {**CONTROL_LIMITS, 125: 280}
    refused_above = dict(table.limits.refused_above)
    assert (refused_above[125], refused_above[None], refused_above[ids.TIME]) == (280, 280, 280)
    assert refused_above[ids.LOG] == CONTROL_LIMITS[ids.LOG]
    assert table.senders == {125}


def test_nothing_is_sent_to_a_distrusted_endpoint() -> None:
    table = TopicTable(10)
    table.announce(ids.SUBSCRIBER, LED)
    table.mark_stale()
    assert table.send_limits == {}
    assert table.announce(ids.SUBSCRIBER, LED) == []
    assert table.send_limits == {100: 150}


def test_too_many_endpoints() -> None:
    table = TopicTable(1)
    table.announce(ids.SUBSCRIBER, LED)
    assert table.announce(ids.PUBLISHER, CHATTER) is None
    assert table.announce(ids.SUBSCRIBER, LED) == []


def test_input_buffer_is_that_of_subscribers_else_of_publishers() -> None:
    table = TopicTable(10)
    assert table.input_buffer_bytes is None
    table.announce(ids.PUBLISHER, CHATTER)
    assert table.input_buffer_bytes == 280
    table.announce(ids.SUBSCRIBER, LED)
    assert table.input_buffer_bytes == 150


def test_limits_are_those_of_a_table_made_again() -> None:
    rng = random.Random(7)
    table = TopicTable(40)
    for step in range(600):
        kind = rng.choice(ids.ANNOUNCEMENTS)
        size = rng.choice((0, 100, 280, 65535))
        info = TopicInfo(rng.randrange(100, 125), rng.choice("abc"), STRING, STRING_MD5, size)
        table.announce(kind, info)
        if step % 50 == 49:
            table.withdraw_all_but([key for key in sorted(table.keys()) if rng.random() < 0.7])
        kept = dict(table._endpoints)
        new_table = TopicTable(40)
        for endpoint in kept.values():
            new_table.announce(endpoint.kind, endpoint.info)
            assert new_table.is_known(endpoint.kind, endpoint.info)
        assert new_table.limits == table.limits
        assert new_table.send_limits == table.send_limits
        assert new_table.senders == table.senders
        assert new_table.incomplete_services() == table.incomplete_services()
        if table.senders:
            largest = max(endpoint.info.buffer_size for key, endpoint in kept.items() if key.sends)
            assert table.limits.refused_above[None] == largest


def test_limits_are_one_value_until_an_endpoint_changes() -> None:
    table = TopicTable(10)
    before = table.limits
    assert before.refused_above == {}
    table.announce(ids.PUBLISHER, CHATTER)
    limits = table.limits
    assert limits != before
    table.announce(ids.PUBLISHER, CHATTER)
    table.mark_stale()
    table.announce(ids.PUBLISHER, CHATTER)
    assert table.limits is limits
    table.withdraw_all_but([])
    assert table.limits == before


def test_a_burst_of_announcements_computes_the_limits_once() -> None:
    sizes: list[int] = []

    def fixed_size(info: TopicInfo) -> None:
        sizes.append(info.topic_id)

    table = TopicTable(256, fixed_size)
    for number in range(250):
        table.announce(ids.PUBLISHER, replace(CHATTER, topic_id=125 + number, buffer_size=MAX_PAYLOAD_BYTES))
    assert len(table.limits.possible) == len(CONTROL_LIMITS) + 250
    assert table.limits is table.limits
    assert len(sizes) == 250
