from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rostether.cli.plot import plot
from rostether.cli.plot.curves import MAX_CURVES, MAX_POINTS, Curves, expand, numbers
from rostether.cli.plot.plot import number_fields
from rostether.msgdef.registry import Registry
from rostether.pictures.axis import Axis
from rostether.pictures.plot import Curve
from rostether.pictures.terminal_plot import as_colored, as_plain, plot_lines
from rostether.rostime import Duration, Time
from unit.cli.command_shell import STORE, LiveGraph, Shell
from unit.cli.talking import publish

SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize(
    ("argument", "fields"),
    [
        ("/scan", ["/scan"]),
        ("/pose/position/x", ["/pose/position/x"]),
        ("/pose/position/x:y:z", ["/pose/position/x", "/pose/position/y", "/pose/position/z"]),
        ("/joints/position[0:4]", ["/joints/position[0:4]"]),
        ("/joints/position[0]:velocity[:2]", ["/joints/position[0]", "/joints/velocity[:2]"]),
        ("imu/x:", ["imu/x"]),
    ],
)
def test_colons_name_more_fields(argument: str, fields: list[str]) -> None:
    assert expand(argument) == fields


def message(type_name: str, **fields: Any) -> Any:
    codec = STORE.codec(type_name)
    return codec.decode(codec.encode(fields))


def test_numbers_in_values() -> None:
    joints = message("sensor_msgs/JointState", name=["a", "b"], position=[0.5, -0.5])
    assert list(numbers("/joints", joints)) == [("/joints/position[0]", 0.5), ("/joints/position[1]", -0.5)]
    assert list(numbers("x", True)) == [("x", 1.0)]
    assert list(numbers("x", Time(2, 500_000_000))) == [("x", 2.5)]
    assert list(numbers("x", Duration(-1, 0))) == [("x", -1.0)]
    assert list(numbers("x", b"\x07")) == [("x[0]", 7.0)]
    assert list(numbers("x", "text")) == []
    assert list(numbers("x", message("std_msgs/String", data="1"))) == []


def test_curves_are_bounded(capsys: pytest.CaptureFixture[str]) -> None:
    curves = Curves()
    assert curves.add(0.0, "a", [0.0] * (MAX_CURVES + 10))
    assert len(curves.names) == MAX_CURVES
    assert "only the first" in capsys.readouterr().err
    for step in range(MAX_POINTS // MAX_CURVES + 100):
        curves.add(step, "a", [1.0])
    (first, *_) = curves.curves()
    assert len(first.points) == MAX_POINTS // MAX_CURVES


def test_curves_keep_the_order_of_their_names() -> None:
    curves = Curves()
    curves.expect("/b", "/a")
    curves.add(0.0, "/a", 1.0)
    curves.add(1.0, "/b", [2.0, 3.0])
    assert curves.names == ["/b[0]", "/b[1]", "/a"]
    assert [curve.points for curve in curves.curves(since_s=0.5)] == [[(1.0, 2.0)], [(1.0, 3.0)], []]


def test_lines_of_a_plot() -> None:
    curve = Curve("/a", [(0.0, 0.0), (5.0, 10.0), (10.0, 0.0)])
    lines = as_plain(plot_lines([curve], 40, 12, Axis(0.0, 10.0)))
    assert len(lines) == 12
    assert max(map(len, lines)) <= 40
    assert any(re.match(r" +10┤ +⡠?[⠁-⣿]+$", line) for line in lines[:3]), lines
    assert lines[-1] == "── /a 0"
    assert re.fullmatch(r" +0 s +5 s +10 s", lines[-2])


def test_curves_have_their_own_colors() -> None:
    curves = [Curve("/a", [(0.0, 0.0)]), Curve("/b", [(1.0, 1.0)])]
    text = as_colored(plot_lines(curves, 40, 10, Axis(0.0, 1.0)), "end")
    styles = {str(span.style) for span in text.spans}
    assert {"rgb(0,114,178)", "rgb(213,94,0)"} <= styles


def test_a_window_without_room_is_allowed() -> None:
    assert plot_lines([Curve("/a", [(0.0, 0.0)])], 1, 1, Axis(0.0, 1.0))


@pytest.fixture
def measure(graph: LiveGraph) -> Callable[[], object]:
    """Publish three ranges as soon as a command listens."""
    ranges = [{"range": value} for value in (1.0, 3.0, 2.0)]
    return lambda: publish(graph, "/scan", "sensor_msgs/Range", *ranges)


def test_without_a_terminal_the_plot_is_printed(shell: Shell, measure: Callable[[], object]) -> None:
    printed = shell.observed("range 2 m", "plot", "/scan/range", before=measure)
    assert printed.splitlines()[-1] == "── /scan/range 2 m"
    assert re.search("[⠁-⣿]", printed)


def texts(file: Path) -> set[str]:
    return {each.text or "" for each in ET.parse(file).getroot().iter(f"{SVG}text")}


def test_pictures_are_saved(shell: Shell, tmp_path: Path, measure: Callable[[], object]) -> None:
    file = tmp_path / "scan.svg"
    words = ("plot", "/scan/range:field_of_view", "--save", str(file))
    assert shell.observed("values", *words, before=measure) == f"{file}: 2 curves, 6 values\n"
    found = texts(file)
    # The title, and a scale for each unit.
    assert {"/scan/range:field_of_view", "/scan/range [m]", "m", "rad"} <= found
    assert "/scan/field_of_view [rad] (right scale)" in found
    assert any(re.fullmatch(r"seconds since \d{4}-\d\d-\d\d \d\d:\d\d:\d\d", each) for each in found)


def test_a_scale_title_and_clock_on_request(
    shell: Shell, tmp_path: Path, measure: Callable[[], object]
) -> None:
    file = tmp_path / "scan.svg"
    more = ("--right", "/scan/max_range", "--title", "Distance", "--clock")
    # The fields of one message come with one subscription.
    words = ("plot", "/scan/range:max_range", "--save", str(file), *more)
    shell.observed("values", *words, before=measure)
    found = texts(file)
    assert {"Distance", "/scan/max_range [m] (right scale)"} <= found
    assert any(re.fullmatch(r"\d{4}-\d\d-\d\d", each) for each in found)


@pytest.mark.font
def test_png(shell: Shell, tmp_path: Path, measure: Callable[[], object]) -> None:
    file = tmp_path / "scan.png"
    shell.observed("values", "plot", "/scan", "--save", str(file), before=measure)
    assert file.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_mistakes_are_reported(shell: Shell, graph: LiveGraph, tmp_path: Path) -> None:
    publish(graph, "/words", "std_msgs/String", {"data": "x"})
    assert "/words/data contains no numbers" in shell.failure("plot", "/words/data", "--for", "60")
    silent = STORE.registry.message_type("std_msgs/Int8")
    graph.do(graph.node("/silent").advertise("/nothing", silent))
    assert "no value of /nothing was received" in shell.failure("plot", "/nothing", "--for", "0.2")
    assert "its name must end with .png" in shell.failure(
        "plot", "/a", "--save", str(tmp_path / "a.dot"), code=2
    )
    assert "at most" in shell.failure("plot", *(f"/t{number}" for number in range(40)), code=2)


def test_colons_may_name_topics(shell: Shell, graph: LiveGraph, tmp_path: Path) -> None:
    def turn() -> None:
        publish(graph, "/wheel/left", "std_msgs/Float32", {"data": 1.0})
        publish(graph, "/wheel/right", "std_msgs/Float32", {"data": 2.0})

    printed = shell.observed(
        "left/data 1.*right/data 2", "plot", "/wheel/left:right", before=turn
    ).splitlines()
    assert printed[-2:] == ["── /wheel/left/data 1", "── /wheel/right/data 2"]


def test_a_field_that_is_not_there_is_named(shell: Shell, measure: Callable[[], object]) -> None:
    measure()
    assert "has no field 'rnge'" in shell.failure("plot", "/scan/range:rnge", "--for", "5")


@pytest.fixture
def became(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    became: list[list[str]] = []
    monkeypatch.setattr(plot, "replace_process", lambda words, _: became.append(words))
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
