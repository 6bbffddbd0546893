from __future__ import annotations

import pytest

from rostether.bridge.setup_lines import SetupLines
from rostether.graph.ports import Level
from rostether.rosserial.events import ServiceRole
from unit.bridge.nodes import World, publisher, service, subscriber


@pytest.fixture
async def world() -> World:
    return await World().open()


async def test_a_buffers_size_is_said_once_for_each_direction(world: World) -> None:
    lines = SetupLines(world.notices)
    for event in (publisher("a"), publisher("b"), subscriber("c"), subscriber("d")):
        lines.note_size(event)
    assert world.reporter.texts == [
        "Note: publish buffer size is 280 bytes",
        "Note: subscribe buffer size is 280 bytes",
    ]


async def test_endpoints_are_said_as_established_hosts_say_them(world: World) -> None:
    lines = SetupLines(world.notices)
    lines.topic(publisher("ultrasound", "sensor_msgs/Range"))
    lines.topic(subscriber("led_out", "std_msgs/Byte"))
    lines.service(service(ServiceRole.SERVER))
    lines.service(service(ServiceRole.CLIENT))
    assert world.reporter.texts == [
        "Setup publisher on ultrasound [sensor_msgs/Range]",
        "Setup subscriber on led_out [std_msgs/Byte]",
        "Setup service server on switch [std_srvs/SetBool]",
        "Setup service client on switch [std_srvs/SetBool]",
    ]
    assert {level for level, _, _ in world.reporter.lines} == {Level.INFO}
