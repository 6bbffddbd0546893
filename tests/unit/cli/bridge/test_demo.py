from __future__ import annotations

import signal
from pathlib import Path

import pytest

from rostether.bridge.health.diagnostics import BoardView, EndpointView
from rostether.cli.bridge.demo_view import DemoView, RecentLines
from rostether.graph.ports import Level
from unit.cli.command_shell import STORE, LiveGraph
from unit.cli.processes import read_until, started


def test_the_demo_is_interrupted(graph: LiveGraph) -> None:
    with started(graph.uri, "demo", "--join") as process:
        read_until(process, "virtual board ready")
        process.send_signal(signal.SIGINT)
        text, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "connect again" not in f"{text}{said}"
    assert not graph.master.api.registrations.nodes


def test_the_demo_keeps_out_of_a_graph_that_runs(graph: LiveGraph) -> None:
    with started(graph.uri, "demo", "--ros1", "--seconds", "20") as process:
        lines = read_until(process, "virtual board ready")
        assert not graph.master.api.registrations.nodes
    own = next(line for line in lines if "Started a ROS master" in line)
    assert graph.uri.rstrip("/") not in own


def test_settings_are_tried_on_the_demo_s_board(graph: LiveGraph, tmp_path: Path) -> None:
    config = tmp_path / "devices.toml"
    config.write_text(
        '[devices.virtual_board]\naddress = "127.0.0.1"\n'
        'required_topics = ["odom"]\naccess = { publish = { deny = ["/tf"] } }\n'
    )
    with started(graph.uri, "demo", "--join", "--config", str(config), "--seconds", "4") as process:
        _, said = process.communicate(timeout=60)
    assert "may not publish /tf" in said
    assert "does not announce odom, which devices.toml requires" in said


def test_the_user_s_own_settings_do_not_spoil_the_demo(
    graph: LiveGraph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path / "rostether" / "devices.toml"
    config.parent.mkdir()
    config.write_text("[defaults]\naccess = { publish = { allow = [] } }\n")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with started(graph.uri, "demo", "--join", "--seconds", "3") as process:
        text, _ = process.communicate(timeout=60)
    assert process.returncode == 0, text


def board(count: int) -> BoardView:
    endpoints = (
        EndpointView("publisher", "ultrasound", "sensor_msgs/Range", 125, 512, True, count, 0, 0),
        EndpointView("subscriber", "toggle_led", "std_msgs/Empty", 100, 512, True, 3, 0, 0),
    )
    return BoardView("/board", "tcp 127.0.0.1:5", True, True, 2, endpoints, 2000, 100, 50, 1, 0, 0, 0, 0)


@pytest.fixture
def view() -> DemoView:
    now_s = 10.0
    count = 0

    def clock() -> float:
        nonlocal now_s
        now_s += 1.0
        return now_s

    def boards() -> list[BoardView]:
        nonlocal count
        count += 20
        return [board(count)]

    recent = RecentLines()
    recent.line(Level.INFO, "Setup publisher on ultrasound", node="/board")
    recent.line(Level.DEBUG, "not shown")
    made = DemoView(boards, clock, recent, "http://localhost:11311/")
    codec = STORE.codec("sensor_msgs/Range")
    made.saw("/ultrasound", codec, [codec.encode({"range": 1.25})])
    return made


def test_what_the_demo_shows_in_one_line(view: DemoView) -> None:
    assert view.line() == "link: waiting for the board"
    view.update()
    view.update()
    assert view.line() == "ultrasound 20.0 Hz (1.25 m); 50 frames, 1 discarded"
    assert view.has_flowed


def test_what_the_demo_shows_in_a_terminal(view: DemoView) -> None:
    from io import StringIO

    from rich.console import Console

    view.update()
    view.update()
    screen = StringIO()
    Console(file=screen, width=120).print(view.render())
    text = screen.getvalue()
    for part in (
        "-> ultrasound",
        "<- toggle_led",
        "20.0",
        "1.25 m",
        "/board: Setup publisher",
        "topic echo /ultrasound",
    ):
        assert part in text
    assert "not shown" not in text
