"""Types every command of the README and the docs, in order, and compares the output with the page.

With WRITE_OUTPUT=1 in the environment, the output of this run is written into the pages.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import runpy
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from docs.page import Step, argv, lines_until, matching_lines, missing_lines, programs, steps
from interop.machines import missing_namespaces, own_loopback
from interop.ros1_peers import free_port
from unit.firmware.sketches import users_cache

REPOSITORY = Path(__file__).parents[2]
on_page_markdown = runpy.run_path(str(REPOSITORY / "docs" / "hooks.py"))["on_page_markdown"]
PAGES = sorted(
    page for page in [REPOSITORY / "README.md", *(REPOSITORY / "docs").rglob("*.md")] if steps(page)
)
TIMEOUT_S = 60.0
# If the output is longer, only the lines that the page already has are updated.
MAX_WHOLE_LINES = 60
WRITES_OUTPUT = bool(os.environ.get("WRITE_OUTPUT"))
# The time that a command may run before Ctrl-C. The complete output is written only if it ends by itself.
RUN_S = 10.0 if WRITES_OUTPUT else 0.5
NEEDS_SIMULATOR = ("board run", "firmware sim ", "sim:")
# Fixed ports, which the pages of two test processes cannot use at the same time.
NEEDS_FIXED_PORTS = re.compile(r"\b1\d{4}\b|ros2|zenoh|demo\b")
# Times and names of this machine, and their replacements in the pages.
NEUTRAL = {
    r"\[\d{10}\.\d{6}\]": "[1700000000.123456]",
    r"/dev/pts/\d+": "/dev/pts/3",
    r"_(joint|relay)_[0-9a-f]+": r"_\1_18eac27b0d2102ce321ffdf5",
    r"\b[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}\b": "9b3ef592-375a-46ab-af4c-4d4a4fcfbf68",
    r"\b(?:the ports are|no serial port found)[^\n\"]*": "the ports are /dev/ttyS0 (serial port)",
}
# The seconds of a time in s or ns; in the pages, the first time of an output has NEUTRAL_SECONDS.
SECONDS = re.compile(r"(?<![\d.(\[])1[789]\d{8}(?=(?:\d{9})?(?!\d))")
NEUTRAL_SECONDS = 1_700_000_000
# The start or the end of a recording; in the pages, recordings start at NEUTRAL_START_S.
RECORDING_TIME = re.compile(r"[A-Z][a-z]{2} \d\d \d{4} \d\d:\d\d:\d\d(\.\d\d) \((\d{10})\.\d\d\)")
NEUTRAL_START_S = int(datetime(2025, 1, 1, 12, tzinfo=UTC).timestamp())
# The exit codes of success and of Ctrl-C.
EXIT_CODES = (0, 130, -signal.SIGINT)
# Commands that look at a graph or a board for a limited time, and can be repeated.
REPEATABLE = re.compile(
    r"(\w+=\S+ |sh at\.sh \w+ |\.venv/bin/)*rostether ((topic|node|service|param|sensor) (list|info|get|call)"
    r"|tf|graph|plot|monitor|doctor|fleet (doctor|list)|conformance tcp)\b"
)
# Other tests type the commands that set up a machine.
SKIPPED_COMMANDS = ("make test", "git clone", "cd ", "pip ", "pipx ", "sudo ")


@pytest.fixture
def network(page: Path) -> Iterator[tuple[str, ...]]:
    """Provide a loopback where the page's ports are free; yield the command prefix that runs a command there.

    Without network namespaces, pages with fixed ports run one after another.
    """
    with own_loopback() as prefix:
        if prefix is not None or not NEEDS_FIXED_PORTS.search(_typed(page)):
            yield prefix or ()
            return
    with (Path(tempfile.gettempdir()) / f"rostether-docs-{os.getuid()}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield ()


class Terminal:
    """Types commands as a reader would, each in a new process group."""

    def __init__(self, folder: Path, home: Path, network: tuple[str, ...]) -> None:
        self._folder = folder
        self._network = network
        self._home = home
        self._running: list[subprocess.Popen[bytes]] = []
        self._master = f"http://localhost:{free_port()}"
        self._environment = {
            name: value
            for name, value in os.environ.items()
            # `make test ARGS=...` passes its variables to children; a reader's `make demo` has none of them.
            if not name.startswith(("ROS", "RMW", "ZENOH", "PYTEST", "MAKE", "MFLAGS", "ARGS"))
        } | {
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "ROS_MASTER_URI": self._master,
            "HOME": str(home),
            "XDG_CACHE_HOME": users_cache(),
            "XDG_STATE_HOME": str(home / ".local/state"),
            "PYTHONUNBUFFERED": "1",
            "COLUMNS": "120",
        }

    def type(self, command: str, expected: tuple[str, ...], *, leave_running: bool) -> list[str]:
        """Run a command until it has printed the expected lines and, unless it is left running, has ended.

        Return the output as the page shows it.
        """
        output = self._home / f"output-{time.monotonic_ns()}"
        process = self._start(command, output)
        deadline = time.monotonic() + TIMEOUT_S
        is_settled = False
        seen_bytes = -1
        while not is_settled:
            ended = process.poll() is not None
            if (output_bytes := output.stat().st_size) != seen_bytes:
                seen_bytes = output_bytes
                printed = self._neutral(output)
                missing = missing_lines(expected, printed)
            failed = ended and process.returncode not in EXIT_CODES
            repeats = (missing or failed) and REPEATABLE.match(command) and time.monotonic() < deadline
            is_settled = not (missing or repeats) and (leave_running or bool(expected) or ended)
            if not is_settled:
                if ended and repeats:
                    # If the graph is not complete yet, the command is repeated.
                    output.unlink()
                    process = self._start(command, output)
                    seen_bytes = -1
                    continue
                if (ended and missing) or time.monotonic() > deadline:
                    pytest.fail(f"`{command}` printed no {missing}, or did not end; it printed:\n{printed}")
                time.sleep(0.02)
        if leave_running:
            assert process.poll() is None, f"`{command}` ended:\n{self._neutral(output)}"
            return _shown(lines_until(expected, printed), expected, printed)
        try:
            ended = process.wait(RUN_S) is not None
        except subprocess.TimeoutExpired:
            ended = False
        status = self._end(process)
        printed = self._neutral(output)
        assert status in EXIT_CODES, f"`{command}` gave {status}:\n{printed}"
        assert "Traceback" not in printed
        lines = printed.rstrip().splitlines() if ended else lines_until(expected, printed)
        return _shown(lines, expected, printed)

    def _start(self, command: str, output: Path) -> subprocess.Popen[bytes]:
        with output.open("wb") as written:
            process = subprocess.Popen(
                [*self._network, *argv(command)],
                cwd=self._folder,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=written,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self._running.append(process)
        return process

    def _neutral(self, output: Path) -> str:
        """Return the output without the names and times of this machine and this run."""
        text = output.read_text(errors="replace").replace(str(self._home), "/home/me")
        # A clone directly below / may have the name of a folder in other paths.
        text = re.sub(rf"(?<![\w/.-]){re.escape(str(REPOSITORY))}(?![\w.-])", "/home/me/rostether", text)
        text = text.replace(self._master, "http://localhost:11311")
        # As a whole word: the machine's name may be a part of another word.
        text = re.sub(rf"(?<![^\W_]){re.escape(socket.gethostname())}(?![^\W_])", "robot", text)
        text = text.replace(self._master.replace("localhost", "127.0.0.1"), "http://127.0.0.1:11311")
        for pattern, neutral in NEUTRAL.items():
            text = re.sub(pattern, neutral, text)
        return _with_neutral_recording_times(_with_neutral_seconds(text))

    @staticmethod
    def _end(process: subprocess.Popen[bytes]) -> int:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.wait(0.5)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        try:
            return process.wait(TIMEOUT_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            pytest.fail(f"Ctrl-C did not end {process.args!r}")

    def close(self) -> None:
        """End the commands that were left running, the last one first."""
        with contextlib.ExitStack() as ending:
            for process in self._running:
                if process.poll() is None:
                    ending.callback(self._end, process)


def _with_neutral_seconds(text: str) -> str:
    first = SECONDS.search(text)
    shift_s = NEUTRAL_SECONDS - int(first[0]) if first else 0
    return SECONDS.sub(lambda found: str(int(found[0]) + shift_s), text)


def _with_neutral_recording_times(text: str) -> str:
    times_s = [int(found[2]) for found in RECORDING_TIME.finditer(text)]

    def neutral(found: re.Match[str]) -> str:
        time_s = NEUTRAL_START_S + int(found[2]) - times_s[0]
        return f"{datetime.fromtimestamp(time_s, UTC):%b %d %Y %H:%M:%S}{found[1]} ({time_s}{found[1]})"

    return RECORDING_TIME.sub(neutral, text)


def _shown(lines: list[str], expected: tuple[str, ...], printed: str) -> list[str]:
    return lines if len(lines) <= MAX_WHOLE_LINES else matching_lines(expected, printed)


def _name(page: Path) -> str:
    return str(page.relative_to(REPOSITORY))


def _marks(page: Path) -> list[pytest.MarkDecorator]:
    """Return the markers of the other programs that a page's commands need."""
    typed = _typed(page)
    marks = [pytest.mark.simavr] if any(part in typed for part in NEEDS_SIMULATOR) else []
    if "micropython hello.py" in typed:
        marks.append(pytest.mark.micropython)
    if "ip netns" in typed:
        marks.append(pytest.mark.skipif(bool(missing_namespaces()), reason=missing_namespaces()))
    return marks


def _typed(page: Path) -> str:
    """Return all commands and files of a page."""
    commands = [command for step in steps(page) for command in step.commands]
    return "\n".join([*commands, *programs(page).values()])


@pytest.mark.timeout(300)
@pytest.mark.parametrize("page", [pytest.param(page, marks=_marks(page), id=_name(page)) for page in PAGES])
def test_page(page: Path, network: tuple[str, ...], tmp_path: Path) -> None:
    # Only the README's commands run in a clone; other pages may name a clone, ~/rostether.
    if "~/rostether" in page.read_text():
        (tmp_path / "rostether").symlink_to(REPOSITORY)
    terminal = Terminal(REPOSITORY if page.name == "README.md" else tmp_path, tmp_path, network)
    for name, text in programs(page).items():
        (tmp_path / name).write_text(text)
    outputs = []
    try:
        for step in steps(page):
            lines = _type_step(terminal, step)
            if step.output is not None:
                outputs.append((step.output, lines))
    finally:
        terminal.close()
    if WRITES_OUTPUT:
        text = page.read_text()
        for (start, end), lines in reversed(outputs):
            text = text[:start] + "".join(f"{line.rstrip()}\n" for line in lines) + text[end:]
        page.write_text(text)


def _type_step(terminal: Terminal, step: Step) -> list[str]:
    commands = [command for command in step.commands if not command.startswith(SKIPPED_COMMANDS)]
    lines = []
    for command in commands:
        last = command is commands[-1]
        expected = step.expected if last else ()
        if "demo" in command.split() and not expected:
            # The reader waits until the demo's board is connected.
            expected = ("Setup publisher on ultrasound",)
        lines = terminal.type(command, expected, leave_running=last and step.leave_running)
    return lines


def test_pages_show_readers_no_marks_and_no_patterns() -> None:
    for page in PAGES:
        shown = on_page_markdown(page.read_text())
        assert not re.search(r'^```.*(test=|title="(Terminal|not run))', shown, re.MULTILINE), page
        assert not [line for step in steps(page) for line in step.expected if line.strip() == "..."], page


def test_there_are_pages() -> None:
    assert len(PAGES) >= 2
