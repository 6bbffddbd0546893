"""The demo in a terminal, on the simulated Uno and on the board in Python."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from rostether.cli.demo import boards
from rostether.cli.demo.boards import demo_board
from rostether.cli.demo.view import RecentLines
from rostether.errors import BoardError
from rostether.simulation.ultrasound import Obstacle
from unit.cli.command_shell import LiveGraph, Shell

LIMIT_S = 60.0


class Terminal:
    """A pseudo-terminal with the demo in it."""

    def __init__(self, leader: int, process: subprocess.Popen[bytes]) -> None:
        self.process = process
        self._leader = leader
        self.seen = b""

    def type(self, keys: bytes) -> None:
        os.write(self._leader, keys)

    def wait_for(self, text: str) -> None:
        deadline_s = time.monotonic() + LIMIT_S
        while text.encode() not in self.seen:
            assert time.monotonic() < deadline_s, f"{text!r} not in {self.seen[-4000:]!r}"
            self.seen += os.read(self._leader, 65536)


@contextmanager
def demo(master_uri: str, *arguments: str) -> Iterator[Terminal]:
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rostether", "demo", "--join", "--ros1", "--no-page", *arguments],
        env={**os.environ, "ROS_MASTER_URI": master_uri, "COLUMNS": "80", "LINES": "30", "TERM": "xterm"},
        stdin=follower,
        stdout=follower,
        stderr=follower,
        start_new_session=True,
    )
    os.close(follower)
    try:
        yield Terminal(leader, process)
    finally:
        process.kill()
        process.wait()
        os.close(leader)


def play(terminal: Terminal, shell: Shell) -> None:
    """Switch the LED and move the obstacle by keys, and read both from the graph."""
    terminal.wait_for("virtual board ready")
    terminal.wait_for("Keys: l LED, arrows obstacle, q quit")
    terminal.type(b"l")
    terminal.wait_for("LED on")
    # From wherever it is to the nearest place, and one step back.
    terminal.type(b"\033[D" * 60 + b"\033[A")
    terminal.wait_for("0.12 m")
    assert "data: True" in shell("topic", "echo", "-n", "1", "/led").out
    terminal.type(b"q")
    assert terminal.process.wait(LIMIT_S) == 0


def test_keys_move_the_python_board(graph: LiveGraph, shell: Shell) -> None:
    with demo(graph.uri, "--board", "python") as terminal:
        play(terminal, shell)


@pytest.mark.simavr
def test_keys_move_the_simulated_uno(graph: LiveGraph, shell: Shell) -> None:
    with demo(graph.uri) as terminal:
        terminal.wait_for("Arduino Uno, simulated")
        play(terminal, shell)


async def test_without_the_compiler_the_board_is_a_python_program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    lines = RecentLines()
    async with demo_board(None, "virtual_board", Obstacle(), lines) as board:
        assert "Python" in board.title
    assert "install" in lines.lines[0]
    with pytest.raises(BoardError):
        async with demo_board(boards.UNO, "virtual_board", Obstacle(), lines):
            pass
