from __future__ import annotations

from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from rostether.bridge.health.diagnostics import BoardView, EndpointView
from rostether.cli.demo.view import DemoFacts, DemoScreen, DemoView, RecentLines, command_to_type
from rostether.graph.ports import Level
from unit.cli.command_shell import STORE

LOG = ["/board: Setup publisher on ultrasound"]
USUAL = DemoFacts("a board", "http://localhost:11311/")


def board(count: int) -> BoardView:
    endpoints = (
        EndpointView("publisher", "ultrasound", "sensor_msgs/Range", 125, 512, True, count, 0, 0),
        EndpointView("subscriber", "toggle_led", "std_msgs/Empty", 100, 512, True, 3, 0, 0),
        EndpointView("service server", "set_led", "std_srvs/SetBool", 101, 512, True, 0, 0, 0),
    )
    return BoardView("/board", "tcp 127.0.0.1:5", True, True, 2, endpoints, 2000, 100, 50, 1, 0, 0, 0)


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

    return DemoView(boards, clock)


def measure(view: DemoView, *distances: float) -> None:
    codec = STORE.codec("sensor_msgs/Range")
    for distance in distances:
        view.add_messages("/ultrasound", codec, [codec.encode({"range": distance})])
        view.update()


def drawn(view: DemoView, facts: DemoFacts, width: int, height: int) -> list[str]:
    screen = StringIO()
    Console(file=screen, width=width, height=height).print(DemoScreen(facts, view, LOG * 50))
    return screen.getvalue().splitlines()


def test_the_rate_of_one_message_a_second_is_steady() -> None:
    tenths = 0

    def boards() -> list[BoardView]:
        nonlocal tenths
        tenths += 2
        return [board(tenths // 10)]

    view = DemoView(boards, lambda: tenths / 10)
    rates = []
    for _ in range(50):
        view.update()
        assert view.board is not None
        rates.append(view.rate_hz(view.board.endpoints[0]))
    # Two messages have arrived after 2 s.
    assert rates[10:] == pytest.approx([1.0] * 40)


def test_line_without_a_terminal(view: DemoView) -> None:
    assert view.line() == "link: waiting for the board"
    measure(view, 2.0, 1.25)
    assert view.line() == "ultrasound 20.0 Hz (1.25 m); 50 frames, 1 discarded"
    assert view.has_messages


@pytest.mark.parametrize(("width", "height"), [(120, 40), (80, 24), (40, 24)])
def test_screen_fits_and_keeps_the_curve(view: DemoView, width: int, height: int) -> None:
    measure(view, 1.0, 2.0, 1.0, 2.0)
    lines = drawn(view, USUAL, width, height)
    assert len(lines) <= height - 1
    assert max(map(len, lines)) <= width
    row = next(line for line in lines if line.startswith("-> ultrasound"))
    assert "2.00 m" in row
    assert row.rstrip().endswith("\u2581\u2588\u2581\u2588")
    assert ("sensor_msgs/Range" in row) == (width == 120)
    assert any(line.startswith("link: negotiated, 50 frames") for line in lines)
    assert LOG[0][: width - 1] in "\n".join(lines)


def test_next_steps_name_a_master_that_is_not_the_usual_one(view: DemoView) -> None:
    usual = "\n".join(drawn(view, USUAL, 120, 40))
    assert "topic echo /ultrasound" in usual
    assert "ROS_MASTER_URI" not in usual
    other = "\n".join(drawn(view, DemoFacts("a board", "http://localhost:11312/", is_in_ros2=True), 120, 40))
    assert "export ROS_MASTER_URI=http://localhost:11312" in other
    assert "topic echo --ros2 zenoh /ultrasound" in other


def test_recent_lines_leave_debug_out() -> None:
    recent = RecentLines()
    recent.report(Level.INFO, "shown", node="/board")
    recent.report(Level.DEBUG, "not shown")
    recent.report_warning(Level.INFO, "shown elsewhere")
    recent.report_warning(Level.WARN, "the port is in use")
    assert list(recent.lines) == ["/board: shown", "the port is in use"]


def test_the_command_is_a_path_unless_path_finds_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / ".cache" / "bin" / "rostether"
    program.parent.mkdir(parents=True)
    program.touch(0o755)
    monkeypatch.setenv("PATH", str(program.parent))
    assert command_to_type() == "rostether"
    monkeypatch.setattr("sys.prefix", str(tmp_path / ".cache"))
    assert command_to_type() == str(program)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sys.argv", ["./rostether"])
    assert command_to_type() == "./rostether"
