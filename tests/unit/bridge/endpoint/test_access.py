"""Endpoints that devices.toml does not allow are not set up, and one line names the entry."""

from __future__ import annotations

from typing import cast

import pytest

from rostether.bridge.endpoint.factory import ACCESS_KINDS, EndpointFactory
from rostether.bridge.endpoint.table import EndpointTable
from rostether.bridge.parameter_relay import ParameterRelay
from rostether.bridge.settings import DEFAULT_SETTINGS
from rostether.errors import AccessDeniedError
from rostether.ports.devices_toml import parse_devices_toml
from rostether.ports.settings import ANY_ACCESS, Access, DeviceSettings, NameRule
from rostether.rosserial.events import ServiceRole, TopicRole
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import ParameterResponse
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, publisher, service, subscriber
from unit.bridge.test_parameter_relay import Answers
from waiting import until

LIMITED = Access(
    publish=NameRule(allow=("/lab/*",)),
    subscribe=NameRule(deny=("/cmd_vel",)),
    serve=NameRule(allow=()),
    call=NameRule(allow=("/lab/*",), deny=("/lab/estop",)),
    parameters=NameRule(allow=("/gains/*",)),
)


@pytest.mark.parametrize(
    ("role", "name", "reason"),
    [
        (TopicRole.PUBLISHER, "/lab/imu", None),
        (TopicRole.PUBLISHER, "/cmd_vel", "may not publish /cmd_vel: access.publish.allow has no entry"),
        (TopicRole.SUBSCRIBER, "/led", None),
        (TopicRole.SUBSCRIBER, "/cmd_vel", 'not subscribe to /cmd_vel: access.subscribe.deny has "/cmd_vel"'),
        (ServiceRole.SERVER, "/switch", "may not serve /switch: access.serve.allow has no entry"),
        (ServiceRole.CLIENT, "/lab/open", None),
        (ServiceRole.CLIENT, "/lab/estop", 'may not call /lab/estop: access.call.deny has "/lab/estop"'),
    ],
)
def test_each_direction_has_its_permission(
    role: TopicRole | ServiceRole, name: str, reason: str | None
) -> None:
    ANY_ACCESS.check(ACCESS_KINDS[role], name)
    if reason is None:
        LIMITED.check(ACCESS_KINDS[role], name)
        return
    with pytest.raises(AccessDeniedError) as caught:
        LIMITED.check(ACCESS_KINDS[role], name)
    assert reason in str(caught.value)


def test_parameters_have_a_permission() -> None:
    LIMITED.check("parameters", "/gains/p")
    with pytest.raises(AccessDeniedError, match=r"may not read /secret: access\.parameters\.allow"):
        LIMITED.check("parameters", "/secret")


async def test_a_denied_endpoint_is_not_set_up_and_reported_once() -> None:
    world = await World().open()
    device = DeviceSettings(access=LIMITED)
    factory = EndpointFactory(world.board, STORE, world.notices, DEFAULT_SETTINGS, device)
    table = EndpointTable(factory, world.notices)
    line = FakeLine()
    for _ in range(3):
        assert not table.announce_topic(subscriber("cmd_vel"), line)
        assert not table.announce_service(service(ServiceRole.SERVER), line)
    assert table.announce_topic(publisher("lab/imu"), line)
    await until(lambda: "/lab/imu" in world.network.snapshot().topics, "the topic")
    assert "/cmd_vel" not in world.network.snapshot().topics
    denied = [text for text in world.reporter.texts if "may not" in text]
    assert len(denied) == 2
    await table.close()


async def test_a_denied_parameter_is_answered_with_nothing() -> None:
    world = await World().open()
    await world.board.set_param("/secret", 7)
    await world.board.set_param("/gains/p", 3)
    answers = Answers()
    relay = ParameterRelay(
        cast(HostLink, answers), world.board, world.notices, DEFAULT_SETTINGS, answers.send, LIMITED
    )
    for name in ("/secret", "secret", "/gains/p", "~gains//p"):
        relay.ask(name)
    await until(lambda: len(answers.given) == 4, "the answers")
    assert answers.given == [
        ParameterResponse(),
        ParameterResponse(),
        ParameterResponse(ints=(3,)),
        ParameterResponse(),
    ]


async def test_rules_of_a_file_reach_the_endpoints() -> None:
    book = parse_devices_toml('[defaults.access]\npublish = { allow = ["/lab/*"] }\n')
    with pytest.raises(AccessDeniedError):
        book.defaults.access.check("publish", "/imu")
