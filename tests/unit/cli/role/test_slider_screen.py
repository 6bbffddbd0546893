from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from unit.cli.command_shell import LiveGraph, Shell
from unit.cli.processes import started
from unit.robot.robots import ARM

LIMIT_S = 60.0


class Terminal:
    """A pseudo-terminal with the sliders in it."""

    def __init__(self, leader: int, process: subprocess.Popen[bytes]) -> None:
        self.process = process
        self._leader = leader
        self._seen = b""

    def type(self, keys: bytes) -> None:
        os.write(self._leader, keys)

    def wait_for(self, text: bytes) -> None:
        deadline_s = time.monotonic() + LIMIT_S
        while text not in self._seen:
            assert time.monotonic() < deadline_s, self._seen
            self._seen += os.read(self._leader, 65536)


@contextmanager
def sliders(master_uri: str) -> Iterator[Terminal]:
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rostether", "role", "joint-state-publisher-gui"],
        env={**os.environ, "ROS_MASTER_URI": master_uri, "COLUMNS": "80", "LINES": "24", "TERM": "xterm"},
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


def test_keys_move_joints_and_q_ends(graph: LiveGraph, shell: Shell) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    with sliders(graph.uri) as terminal:
        terminal.wait_for(b"> j0")
        terminal.type(b"\033[B\033[5~")
        terminal.wait_for(b"> j1")
        # It shows its joints before the master knows its topic; then echo says that it waits.
        received = shell("topic", "echo", "-n", "1", "/joint_states/position")
        assert received.out.startswith("[0.0, 0.4, 0.0]"), received
        terminal.type(b"q")
        terminal.wait_for(b"\033[?1049l")
        assert terminal.process.wait(LIMIT_S) == 0


def test_ctrl_c_gives_the_terminal_back(graph: LiveGraph) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    with sliders(graph.uri) as terminal:
        terminal.wait_for(b"> j0")
        terminal.process.send_signal(signal.SIGINT)
        terminal.wait_for(b"\033[?1049l")
        terminal.process.wait(LIMIT_S)


def test_without_a_terminal_it_publishes_zeros(graph: LiveGraph, shell: Shell) -> None:
    graph.do(graph.node("setter").set_param("/robot_description", ARM))
    with started(graph.uri, "role", "joint-state-publisher-gui", "_rate:=50") as process:
        shell("topic", "echo", "-n", "1", "/joint_states")
        process.terminate()
        _, said = process.communicate(timeout=LIMIT_S)
    assert "no terminal for the sliders" in said
