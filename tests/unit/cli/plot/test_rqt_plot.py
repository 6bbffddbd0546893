from __future__ import annotations

import pytest

from rostether.cli.plot import rqt_plot
from rostether.cli.plot.rqt_plot import number_fields
from rostether.msgdef.registry import Registry
from unit.cli.command_shell import STORE, LiveGraph, Shell


@pytest.fixture
def became(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    became: list[list[str]] = []
    monkeypatch.setattr(rqt_plot, "replace_process", lambda words, _: became.append(words))
    return became


def test_the_numbers_of_a_message() -> None:
    registry = Registry()
    range_fields = ["radiation_type", "field_of_view", "min_range", "max_range", "range"]
    assert number_fields("sensor_msgs/Range", registry) == range_fields
    assert number_fields("std_msgs/String", registry) == []
    assert number_fields("nowhere/Nothing", registry) == []
    assert number_fields("*", registry) == []


def test_published_numbers_are_plotted(graph: LiveGraph, shell: Shell, became: list[list[str]]) -> None:
    node = graph.node("/board")
    for topic, kind in (("/b", "std_msgs/Float32"), ("/a", "std_msgs/Int16"), ("/c", "std_msgs/String")):
        graph.do(node.advertise(topic, STORE.registry.message_type(kind)))
    result = shell("role", "rqt-plot")
    assert result.err == "rostether plot /a/data /b/data\n"
    assert became[0][-3:] == ["plot", "/a/data", "/b/data"]


def test_named_fields_are_plotted(shell: Shell, became: list[list[str]]) -> None:
    assert shell.output("role", "rqt-plot", "/a/x:y", "-w", "5") == ""
    assert became[0][-4:] == ["plot", "/a/x:y", "-w", "5"]


def test_nothing_to_plot(graph: LiveGraph, shell: Shell, became: list[list[str]]) -> None:
    assert "no topic with numbers is published" in shell.failure("role", "rqt-plot")
    assert became == []
