"""The demo in a terminal, on the simulated Uno and on the board in Python."""

from __future__ import annotations

import pytest

from programs import TIMEOUT_S, Terminal, in_terminal, running
from rostether.cli.demo import setup
from rostether.cli.demo.setup import demo_board
from rostether.cli.demo.view import RecentLines
from rostether.errors import BoardError
from rostether.simulation.ultrasound import Obstacle
from unit.cli.command_shell import LiveGraph, Shell

COMMANDS = "/virtual_board_simulation/command"
DEMO = ("demo", "--join", "--ros1", "--no-page")


def play(terminal: Terminal, shell: Shell) -> None:
    """Switch the LED and move the obstacle by keys, and read both from the graph."""
    terminal.wait_for("virtual board ready")
    terminal.wait_for("Keys: l LED, arrows obstacle, q quit")
    terminal.type(b"l")
    terminal.wait_for("LED on")
    # From any position to the nearest one, and one step back.
    terminal.type(b"\033[D" * 60 + b"\033[A")
    terminal.wait_for("0.12 m")
    assert "data: True" in shell("topic", "echo", "-n", "1", "/led").out
    terminal.type(b"q")
    assert terminal.process.wait(TIMEOUT_S) == 0


def test_keys_move_the_python_board(graph: LiveGraph, shell: Shell) -> None:
    with in_terminal(*DEMO, "--board", "python", lines=30, ROS_MASTER_URI=graph.uri) as terminal:
        play(terminal, shell)


@pytest.mark.simavr
def test_keys_move_the_simulated_uno(graph: LiveGraph, shell: Shell) -> None:
    with in_terminal(*DEMO, lines=30, ROS_MASTER_URI=graph.uri) as terminal:
        terminal.wait_for("Arduino Uno, simulated")
        # As the dashboard's page does when the obstacle is dragged or taken away.
        for command, shown in (("range 1.5", "1.50 m"), ("range none", "inf m")):
            with running(
                *("topic", "pub", "-r", "2", COMMANDS, "std_msgs/String", command), ROS_MASTER_URI=graph.uri
            ):
                terminal.wait_for(shown)
        play(terminal, shell)


async def test_without_the_compiler_the_board_is_a_python_program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    lines = RecentLines()
    async with demo_board(None, "virtual_board", Obstacle(), lines) as board:
        assert "Python" in board.title
    assert "install" in lines.lines[0]
    with pytest.raises(BoardError):
        async with demo_board(setup.UNO, "virtual_board", Obstacle(), lines):
            pass
