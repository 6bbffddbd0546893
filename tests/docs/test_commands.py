"""Every command of the README and the docs is typed here, in order, and prints what the page says."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from docs.page import Step, missing_lines, programs, steps
from interop.machines import own_loopback
from interop.ros1_peers import free_port
from unit.firmware.sketches import users_cache

REPOSITORY = Path(__file__).parents[2]
PAGES = sorted(
    page for page in [REPOSITORY / "README.md", *(REPOSITORY / "docs").rglob("*.md")] if steps(page)
)
PATIENCE_S = 60.0
SIMULATING = ("board run", "firmware sim ", "sim:")
# A port by its number, or ROS 2's of everybody: what the pages of two test processes may fight over.
SHARING = re.compile(r"\b1\d{4}\b|ros2|zenoh|demo\b")
# Commands that set a machine up are typed by tests of their own.
NOT_TYPED = ("make test", "git clone", "cd ", "pip ", "pipx ", "sudo ")


@pytest.fixture
def network(page: Path) -> Iterator[tuple[str, ...]]:
    """Have a loopback where the ports that a page names are free; yields how its commands begin there.

    Without network namespaces, pages that name ports run one after another.
    """
    with own_loopback() as entering:
        if entering is not None or not SHARING.search(_typed(page)):
            yield entering or ()
            return
    with (Path(tempfile.gettempdir()) / f"rostether-docs-{os.getuid()}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield ()


class Terminal:
    """Types commands as a reader would, each in a process group of its own."""

    def __init__(self, folder: Path, home: Path, network: tuple[str, ...]) -> None:
        self._folder = folder
        self._network = network
        self._home = home
        self._running: list[subprocess.Popen[bytes]] = []
        self._environment = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("ROS", "RMW", "ZENOH", "PYTEST"))
        } | {
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "ROS_MASTER_URI": f"http://localhost:{free_port()}",
            "HOME": str(home),
            "XDG_CACHE_HOME": users_cache(),
            "PYTHONUNBUFFERED": "1",
            "COLUMNS": "120",
        }

    def type(self, command: str, expected: tuple[str, ...], *, leave_running: bool) -> None:
        """Run one command until it has printed what is expected and, unless left running, has ended."""
        printed = self._home / f"output-{time.monotonic_ns()}"
        with printed.open("wb") as output:
            process = subprocess.Popen(
                [*self._network, "bash", "-c", command],
                cwd=self._folder,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self._running.append(process)
        deadline = time.monotonic() + PATIENCE_S
        while (missing := missing_lines(expected, printed.read_text(errors="replace"))) or (
            not leave_running and not expected and process.poll() is None
        ):
            ended = process.poll() is not None
            if (ended or time.monotonic() > deadline) and missing_lines(
                expected, printed.read_text(errors="replace")
            ):
                pytest.fail(
                    f"`{command}` never printed {missing}; it printed:\n{printed.read_text(errors='replace')}"
                )
            if time.monotonic() > deadline:
                pytest.fail(f"`{command}` did not end; it printed:\n{printed.read_text(errors='replace')}")
            time.sleep(0.02)
        if leave_running:
            assert process.poll() is None, f"`{command}` ended:\n{printed.read_text(errors='replace')}"
            return
        status = self._end(process)
        assert status in (0, 130, -signal.SIGINT), (
            f"`{command}` gave {status}:\n{printed.read_text(errors='replace')}"
        )
        assert "Traceback" not in printed.read_text(errors="replace")

    @staticmethod
    def _end(process: subprocess.Popen[bytes]) -> int:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.wait(0.5)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        try:
            return process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            pytest.fail(f"Ctrl-C did not end {process.args!r}")

    def close(self) -> None:
        """End what was left running, the last first, however each of them ends."""
        with contextlib.ExitStack() as ending:
            for process in self._running:
                if process.poll() is None:
                    ending.callback(self._end, process)


def _name(page: Path) -> str:
    return str(page.relative_to(REPOSITORY))


def _needs(page: Path) -> list[pytest.MarkDecorator]:
    """Return the peers that a page's commands need besides our own."""
    return [pytest.mark.simavr] if any(sign in _typed(page) for sign in SIMULATING) else []


def _typed(page: Path) -> str:
    """Return all that is typed and saved for a page."""
    commands = [command for step in steps(page) for command in step.commands]
    return "\n".join([*commands, *programs(page).values()])


@pytest.mark.timeout(300)
@pytest.mark.parametrize("page", [pytest.param(page, marks=_needs(page), id=_name(page)) for page in PAGES])
def test_page(page: Path, network: tuple[str, ...], tmp_path: Path) -> None:
    # Only the README speaks to someone who stands in a clone; others may name one, ~/rostether.
    if "~/rostether" in page.read_text():
        (tmp_path / "rostether").symlink_to(REPOSITORY)
    terminal = Terminal(REPOSITORY if page.name == "README.md" else tmp_path, tmp_path, network)
    for name, text in programs(page).items():
        (tmp_path / name).write_text(text)
    try:
        for step in steps(page):
            _type_step(terminal, step)
    finally:
        terminal.close()


def _type_step(terminal: Terminal, step: Step) -> None:
    commands = [command for command in step.commands if not command.startswith(NOT_TYPED)]
    for command in commands:
        last = command is commands[-1]
        expected = step.expected if last else ()
        if "demo" in command.split() and not expected:
            # The reader watches until the demo's board is there.
            expected = ("Setup publisher on ultrasound",)
        terminal.type(command, expected, leave_running=last and step.leave_running)


def test_command_reference_is_up_to_date() -> None:
    script = REPOSITORY / "scripts" / "write-command-reference"
    subprocess.run([sys.executable, str(script), "--check"], check=True)


def test_there_are_pages() -> None:
    assert len(PAGES) >= 2
