from __future__ import annotations

import asyncio
import json
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
    """Publishes at 100 Hz until the test ends."""
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
RATE = r"average rate: \d+\.\d{3}\n\tmin: \d+\.\d{3}s max: \d+\.\d{3}s std dev: \d+\.\d{5}s window: \d+\n"

Measured: TypeAlias = Callable[..., str]


@pytest.fixture
def measured(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> Measured:
    """Measures until the whole output matches a pattern, for longer on a busy machine."""

    def measure(pattern: str, *words: str) -> str:
        for period_s in (0.3, 3.0, 30.0):
            monkeypatch.setattr(topic_meter, "REPORT_PERIOD_S", period_s)
            printed = shell("topic", *words).out
            if re.fullmatch(pattern, printed):
                return printed
        raise AssertionError(printed)

    return measure


def test_hz(play: Play, measured: Measured) -> None:
    play("/name", *LOW_AND_HIGH)
    measured(rf"subscribed to \[/name\]\n({RATE}){{2}}", "hz", "-n", "2", "name")


def test_hz_of_what_a_filter_lets_through(play: Play, measured: Measured, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    arguments = ("hz", "-n", "1", "--wall-time", "/name")
    record = json.loads(measured(r"\{.*\}\n", *arguments, "--json", "--filter", "m.data == 'high'"))
    assert record["rate_hz"] > 0
    assert record["topic"] == "/name"
    assert "no new messages" in shell("topic", *arguments, "--filter", "m.data == 'other'").out
    assert "there is no .dta; the fields are" in shell.failure(
        "topic", "hz", "--filter", "m.dta == 1", "/name"
    )


def test_hz_of_several_topics_is_a_table(graph: LiveGraph, play: Play, measured: Measured) -> None:
    play("/a", *LOW_AND_HIGH)
    publish(graph, "/b", "std_msgs/Bool")
    table = r"(.*\n){2} *topic +rate +min_delta +max_delta +std_dev +window *\n=+\n */a .* 5 *\n(.*\n)*"
    measured(table, "hz", "-n", "1", "-w", "5", "/a", "/b")


def test_nothing_new(graph: LiveGraph, shell: Shell) -> None:
    publish(graph, "/b", "std_msgs/Bool")
    assert shell.output("topic", "hz", "-n", "1", "/b") == "subscribed to [/b]\nno new messages\n"


def test_bw(play: Play, measured: Measured) -> None:
    play("/name", *LOW_AND_HIGH)
    sizes = r"\tmean: 7\.\d{2}B min: 7\.00B max: 8\.00B window: \d+\n"
    measured(rf"subscribed to \[/name\]\naverage: \d+\.\d{{2}}B/s\n{sizes}", "bw", "-n", "1", "/name")
    pattern = r'\{"topic": "/name", .*"min_bytes": 7, "max_bytes": 8, .*\}\n'
    measured(pattern, "bw", "-n", "1", "--json", "/name")


def test_delay(play: Play, measured: Measured) -> None:
    play("/r", "sensor_msgs/Range", {"header": {"stamp": {"secs": 5}}})
    measured(r".*\naverage delay: \d+\.\d{3}\n.*\n", "delay", "-n", "1", "/r")
    record = json.loads(measured(r"\{.*\}\n", "delay", "-n", "1", "--json", "/r"))
    assert record["mean_s"] > 0


def test_delay_needs_a_header(play: Play, shell: Shell) -> None:
    play("/name", *LOW_AND_HIGH)
    assert "/name has no header" in shell.failure("topic", "delay", "/name")


def test_simulated_time_is_pointed_out(
    graph: LiveGraph, play: Play, shell: Shell, measured: Measured
) -> None:
    play("/name", *LOW_AND_HIGH)
    graph.do(graph.node("setter").set_param("/use_sim_time", True))
    result = shell("topic", "hz", "-n", "1", "/name")
    assert result.err == "WARNING: may be using simulated time\n"
    # Without /clock there is no simulated time; this machine's clock always works.
    assert result.out == "subscribed to [/name]\nno new messages\n"
    measured(rf"subscribed to \[/name\]\n{RATE}", "hz", "-n", "1", "--wall-time", "/name")


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
