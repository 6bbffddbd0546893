"""Settings of a board in devices.toml apply to its node and its connections."""

from __future__ import annotations

import pytest

from rostether.bridge.board_node import (
    LINE_PERIOD_S,
    RESUME_LINES,
    SAVED_LINES,
    SUMMARY_PERIOD_S,
    BoardNode,
    SetupLines,
)
from rostether.bridge.settings import BridgeSettings
from rostether.graph.ports import Level
from rostether.ports.devices_toml import parse_devices_toml
from rostether.rosserial.events import ServiceRole
from unit.bridge.nodes import STORE, World, publisher, service, subscriber


async def test_limits_of_one_board_count_more_than_those_of_all() -> None:
    world = await World().open()
    book = parse_devices_toml(
        '[devices.a]\nport = "/x"\nlimits = { frame_bytes = 100, endpoints = 3, subscriber_bytes = 65536 }'
    )
    settings = BridgeSettings(frame_bytes=1000, queue_bytes=8192)
    node = BoardNode(world.board, STORE, world.reporter, lambda: 0.0, settings, book.devices[0])
    config = node.link_config()
    assert (config.max_payload_bytes, config.max_endpoints) == (100, 3)
    assert (node.settings.subscriber_bytes, node.settings.queue_bytes) == (65536, 8192)


class Clock:
    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
async def world() -> World:
    return await World().open()


async def test_a_buffers_size_is_reported_once_for_each_direction(world: World) -> None:
    lines = SetupLines(world.notices, Clock())
    for event in (publisher("a"), publisher("b"), subscriber("c"), subscriber("d")):
        lines.note_size(event)
    assert world.reporter.texts == [
        "Note: publish buffer size is 280 bytes",
        "Note: subscribe buffer size is 280 bytes",
    ]


async def test_endpoints_are_reported_like_in_established_hosts(world: World) -> None:
    lines = SetupLines(world.notices, Clock())
    lines.report_topic(publisher("ultrasound", "sensor_msgs/Range"))
    lines.report_topic(subscriber("led_out", "std_msgs/Byte"))
    lines.report_service(service(ServiceRole.SERVER))
    lines.report_service(service(ServiceRole.CLIENT))
    assert world.reporter.texts == [
        "Setup publisher on ultrasound [sensor_msgs/Range]",
        "Setup subscriber on led_out [std_msgs/Byte]",
        "Setup service server on switch [std_srvs/SetBool]",
        "Setup service client on switch [std_srvs/SetBool]",
    ]
    assert {level for level, _, _ in world.reporter.lines} == {Level.INFO}


async def test_a_board_that_reconnects_all_day_causes_few_lines(world: World) -> None:
    clock = Clock()
    lines = SetupLines(world.notices, clock)
    for _ in range(20_000):
        lines.connected()
        for name in "abcdefgh":
            lines.note_size(publisher(name))
            lines.report_topic(publisher(name))
        clock.now_s += 0.5
    hours = clock.now_s / 3600
    reported = world.reporter.having("Setup publisher")
    assert len(reported) <= SAVED_LINES + hours * 3600 / LINE_PERIOD_S
    summaries = world.reporter.having("announces its topics repeatedly; these lines are omitted (")
    assert "omitted (1 so far)" in summaries[0]
    assert 1 < len(summaries) <= clock.now_s / SUMMARY_PERIOD_S + 1


async def test_a_board_that_stops_flooding_is_reported_completely_again(world: World) -> None:
    clock = Clock()
    lines = SetupLines(world.notices, clock)
    for _ in range(SAVED_LINES + 10):
        lines.report_topic(publisher("a"))
    world.reporter.lines.clear()
    clock.now_s += LINE_PERIOD_S * RESUME_LINES
    for name in "bcd":
        lines.report_topic(publisher(name))
    assert [text.split()[3] for text in world.reporter.texts] == ["b", "c", "d"]
