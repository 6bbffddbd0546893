from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Iterator
from itertools import cycle
from typing import Any, TypeAlias

import pytest

from rostether.cli.topic import meter as topic_meter
from unit.cli.command_shell import STORE, LiveGraph, Shell
from unit.cli.talking import command_node, in_background, publish, shut_down


@pytest.fixture(autouse=True)
def _brief(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(topic_meter, "REPORT_PERIOD_S", 0.3)


Play: TypeAlias = Callable[..., None]


@pytest.fixture
def play(graph: LiveGraph) -> Iterator[Play]:
    """Publishes at 100 Hz, as long as the test lasts."""
    playing = []

    def begin(topic: str, type_name: str, *messages: dict[str, Any]) -> None:
        codec = STORE.codec(type_name)
        node = graph.node(f"player{topic.replace('/', '_')}")
        publisher = graph.do(node.advertise(topic, STORE.registry.message_type(type_name)))

        async def send() -> None:
            for message in cycle(messages):
                publisher.publish_raw([codec.encode(message)])
                await asyncio.sleep(0.01)

        playing.append(graph.begin(send()))

    yield begin
    for each in playing:
        each.cancel()


LOW_AND_HIGH = ("std_msgs/String", {"data": "low"}, {"data": "high"})


def test_hz(play: Play, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    lines = shell.output("topic", "hz", "-n", "2", "name").splitlines()
    assert lines[0] == "subscribed to [/name]"
    assert re.fullmatch(r"average rate: \d+\.\d{3}", lines[1])
    pattern = r"\tmin: \d+\.\d{3}s max: \d+\.\d{3}s std dev: \d+\.\d{5}s window: \d+"
    assert re.fullmatch(pattern, lines[2])
    assert len(lines) == 5


def test_hz_of_what_a_filter_lets_through(play: Play, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    arguments = ("topic", "hz", "--json", "-n", "1", "--wall-time")
    record = shell(*arguments, "--filter", "m.data == 'high'", "/name").records[0]
    assert 0 < record["rate_hz"] < 75
    assert record["topic"] == "/name"
    assert "there is no .dta; the fields are" in shell.failure(
        "topic", "hz", "--filter", "m.dta == 1", "/name"
    )


def test_hz_of_several_topics_is_a_table(graph: LiveGraph, play: Play, shell: Shell) -> None:
    play("/a", *LOW_AND_HIGH)
    publish(graph, "/b", "std_msgs/Bool")
    lines = shell.output("topic", "hz", "-n", "1", "-w", "5", "/a", "/b").splitlines()
    assert lines[2].split() == ["topic", "rate", "min_delta", "max_delta", "std_dev", "window"]
    assert lines[4].split()[0] == "/a"
    assert lines[4].split()[-1] == "5"


def test_nothing_new(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/b", "std_msgs/Bool")
    assert shell.output("topic", "hz", "-n", "1", "/b") == "subscribed to [/b]\nno new messages\n"


def test_bw(play: Play, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    lines = shell.output("topic", "bw", "-n", "1", "/name").splitlines()
    assert lines[0] == "subscribed to [/name]"
    assert re.fullmatch(r"average: \d+\.\d{2}B/s", lines[1])
    assert re.fullmatch(r"\tmean: 7\.\d{2}B min: 7\.00B max: 8\.00B window: \d+", lines[2])
    record = shell("topic", "bw", "-n", "1", "--json", "/name").records[0]
    assert (record["topic"], record["min_bytes"], record["max_bytes"]) == ("/name", 7, 8)


def test_delay(play: Play, shell: Shell) -> None:
    play("/r", "sensor_msgs/Range", {"header": {"stamp": {"secs": 5}}})
    lines = shell.output("topic", "delay", "-n", "1", "/r").splitlines()
    assert re.fullmatch(r"average delay: \d+\.\d{3}", lines[1])
    record = shell("topic", "delay", "-n", "1", "--json", "/r").records[0]
    assert record["mean_s"] > 0


def test_delay_needs_a_header(play: Play, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    assert "/name has no header" in shell.failure("topic", "delay", "/name")


def test_simulated_time_is_pointed_out(graph: LiveGraph, play: Play, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    graph.do(graph.node("setter").set_param("/use_sim_time", True))
    result = shell("topic", "hz", "-n", "1", "/name")
    assert result.err == "WARNING: may be using simulated time\n"
    # Without a /clock there is no time to measure by; the wall's is there.
    assert result.out == "subscribed to [/name]\nno new messages\n"
    assert "average rate" in shell("topic", "hz", "-n", "1", "--wall-time", "/name").out


def test_reports_end_when_the_node_is_shut_down(graph: LiveGraph, shell: Shell) -> None:
    publisher = publish(graph, "/b", "std_msgs/Bool")

    def end() -> None:
        graph.wait_until(lambda: publisher.subscriber_count > 0)
        name = command_node(graph)
        assert name is not None
        shut_down(graph, name)

    ending = in_background(end)
    assert shell("topic", "hz", "/b").code == 0
    ending.join(60)
