"""The commands and files of the page on fleets, with network namespaces as machines."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from docs.page import argv, commands_on_machines, programs
from firmware.examples.stage import build_example
from interop.machines import Machines, machines, missing_namespaces

HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"
PAGE = HOW_TO / "fleet-of-robots.md"
COMMANDS = commands_on_machines(PAGE)
TIMEOUT_S = 60.0
LAMP = 'rostether service call --ros2 zenoh /robot1/lamp std_srvs/srv/SetBool "{data: true}"'
TWISTS = "/robot1/cmd_vel geometry_msgs/msg/Twist"
ECHO = "rostether topic echo --ros2 zenoh --once /robot1/chatter"

pytestmark = [
    pytest.mark.simavr,
    pytest.mark.timeout(300),
    pytest.mark.skipif(bool(missing_namespaces()), reason=missing_namespaces()),
]


class Terminals:
    """Types the page's commands on its machines, with a simulated board instead of the port."""

    def __init__(self, network: Machines, folder: Path, board: Path) -> None:
        self._network = network
        self._folder = folder
        self._board = board
        self._running: list[subprocess.Popen[bytes]] = []
        self._environment = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("ROS", "RMW", "ZENOH", "PYTEST"))
        } | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONUNBUFFERED": "1"}

    def start(self, machine: str, command: str, expected: str) -> Path:
        """Type a command that keeps running, and wait until it has printed a text; return the file with its
        output.
        """
        printed = self._folder / f"output-{len(self._running)}"
        command = command.replace("/dev/ttyACM0?", f"sim:{self._board}?board=uno&name=arm&")
        with printed.open("wb") as output:
            process = subprocess.Popen(
                [*self._network.on(machine), *argv(command)],
                cwd=self._folder,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self._running.append(process)
        deadline_s = time.monotonic() + TIMEOUT_S
        while expected not in printed.read_text(errors="replace"):
            assert process.poll() is None, printed.read_text()
            assert time.monotonic() < deadline_s, printed.read_text()
            time.sleep(0.02)
        return printed

    def type(self, machine: str, command: str, timeout_s: float = TIMEOUT_S) -> str:
        """Type a command that ends, or end it after a time limit; return its output."""
        with subprocess.Popen(
            [*self._network.on(machine), *argv(command)],
            cwd=self._folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        ) as process:
            try:
                return process.communicate(timeout=timeout_s)[0]
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGINT)
                return process.communicate(timeout=TIMEOUT_S)[0]

    def end(self) -> None:
        """End the commands that were left running."""
        for process in reversed(self._running):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGINT)
        for process in self._running:
            try:
                process.wait(TIMEOUT_S)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


@pytest.fixture(scope="module")
def network() -> Iterator[Machines]:
    with machines("robot1", "robot2", "laptop", "visitor") as network:
        yield network


@pytest.fixture
async def board(tmp_path: Path) -> Path:
    """The sketch of the page on ROS 2."""
    sketch = tmp_path / "Lamp" / "Lamp.ino"
    sketch.parent.mkdir()
    sketch.write_text(programs(HOW_TO / "ros2.md")["Lamp.ino"])
    return (await build_example(sketch, "uno")).elf


@contextmanager
def terminals(network: Machines, folder: Path, board: Path) -> Iterator[Terminals]:
    terminal_group = Terminals(network, folder, board)
    try:
        yield terminal_group
    finally:
        terminal_group.end()


def test_each_machine_receives_topics_of_the_others(network: Machines, tmp_path: Path, board: Path) -> None:
    with terminals(network, tmp_path, board) as terminal_group:
        for machine in ("robot1", "robot2"):
            terminal_group.start(machine, COMMANDS[f"on {machine}"][0], "Setup publisher on chatter")
        terminal_group.start("laptop", COMMANDS["on laptop"][0], "Press Ctrl-C")
        for command in COMMANDS["on laptop, and ended"]:
            assert "data: hello world!" in terminal_group.type("laptop", command)


def test_only_known_certificates_are_admitted(network: Machines, tmp_path: Path, board: Path) -> None:
    files = programs(PAGE)
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "visitor.json5").write_text(files["laptop.json5"].replace("laptop.", "visitor."))
    subprocess.run(["bash", "-e", "certificates.sh"], cwd=tmp_path, check=True, capture_output=True)
    with terminals(network, tmp_path, board) as terminal_group:
        terminal_group.start(
            "robot1", COMMANDS["on robot1, with certificates"][0], "Setup publisher on chatter"
        )
        (command,) = COMMANDS["on laptop, with certificates"]
        terminal_group.start("laptop", command, "Press Ctrl-C")
        terminal_group.start("visitor", command.replace("laptop", "visitor"), "Press Ctrl-C")
        assert "data: hello world!" in terminal_group.type("laptop", ECHO)
        assert "message='lit'" in terminal_group.type("laptop", LAMP)
        assert "data: hello world!" in terminal_group.type("visitor", ECHO)
        assert "message=" not in terminal_group.type("visitor", LAMP, 3.0)
        received_commands = terminal_group.start("robot1", f"rostether topic echo --ros2 zenoh {TWISTS}", "")
        pub = f"rostether topic pub --ros2 zenoh -r 10 {TWISTS}"
        terminal_group.start("visitor", f"{pub} '{{linear: {{x: 1.0}}}}'", "publishing #5")
        terminal_group.start("laptop", f"{pub} '{{linear: {{x: 2.0}}}}'", "publishing #5")
        deadline_s = time.monotonic() + TIMEOUT_S
        while "x: 2.0" not in received_commands.read_text():
            assert time.monotonic() < deadline_s
            time.sleep(0.02)
        assert "x: 1.0" not in received_commands.read_text()
        # Without a certificate, the port does not answer.
        for address in ("tcp/robot1:7447", "tls/robot1:7448"):
            variable = f"ZENOH_CONFIG_OVERRIDE='connect/endpoints=[\"{address}\"]'"
            assert "data:" not in terminal_group.type("robot2", f"{variable} {ECHO}", 2.0)
