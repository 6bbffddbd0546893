"""Processes that tests start have the default signal handlers, and end with the tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from children import MARK
from interop.ros1_peers import ros_environment

TESTS = Path(__file__).parents[1]
TIMEOUT_S = 60.0
IGNORED = (signal.SIGINT, signal.SIGQUIT, signal.SIGHUP)
CHECKS_SIGNALS = """
import subprocess, sys

CODE = "import signal; print([signal.getsignal(n) in (0, signal.default_int_handler) for n in (1, 2, 3)])"

def test_signals():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert done.stdout == "[True, True, True]\\n"
"""
LEAVES_A_PROCESS = """
import subprocess, time

def test_leaving():
    left = subprocess.Popen(["sleep", "600"], start_new_session=True)
    with open("pid", "w") as file:
        print(left.pid, file=file)
    WHAT_NEXT
"""

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


def start(folder: Path, test: str, *options: str, ignores_signals: bool = False) -> subprocess.Popen[str]:
    """Start pytest with one test, in an empty folder."""
    (folder / "test_it.py").write_text(test)

    def ignore() -> None:
        for number in IGNORED:
            signal.signal(number, signal.SIG_IGN)

    return subprocess.Popen(
        [sys.executable, "-m", "pytest", "-p", "children", "-c", "/dev/null", *options, "test_it.py"],
        cwd=folder,
        # Loading plugins would take half of the time.
        env={**os.environ, "PYTHONPATH": str(TESTS), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=ignore if ignores_signals else None,
    )


def wait_until_gone(pid: int) -> None:
    """Wait until a process has ended; a zombie counts as ended."""
    deadline = time.monotonic() + TIMEOUT_S
    while time.monotonic() < deadline:
        try:
            if ") Z " in Path(f"/proc/{pid}/stat").read_text():
                return
        except OSError:
            return
        time.sleep(0.01)
    pytest.fail(f"{pid} still runs")


def test_children_have_default_signal_handlers(tmp_path: Path) -> None:
    printed, _ = start(tmp_path, CHECKS_SIGNALS, ignores_signals=True).communicate(timeout=TIMEOUT_S)
    assert "1 passed" in printed, printed


def test_programs_of_a_failed_test_are_killed(tmp_path: Path) -> None:
    printed, _ = start(tmp_path, LEAVES_A_PROCESS.replace("WHAT_NEXT", "1 / 0")).communicate(
        timeout=TIMEOUT_S
    )
    assert "test_it.py left running: sleep 600" in printed
    assert "1 failed, 1 error" in printed
    wait_until_gone(int((tmp_path / "pid").read_text()))


@pytest.mark.parametrize("options", [(), ("-p", "xdist.plugin", "-n1")])
def test_sigterm_ends_the_tests_and_their_programs(tmp_path: Path, options: tuple[str, ...]) -> None:
    running = start(tmp_path, LEAVES_A_PROCESS.replace("WHAT_NEXT", "time.sleep(600)"), *options)
    pid_file = tmp_path / "pid"
    deadline = time.monotonic() + TIMEOUT_S
    while not pid_file.exists() or not pid_file.read_text().endswith("\n"):
        assert time.monotonic() < deadline, "the test did not start"
        time.sleep(0.01)
    running.terminate()
    printed, _ = running.communicate(timeout=TIMEOUT_S)
    assert "KeyboardInterrupt" in printed
    wait_until_gone(int(pid_file.read_text()))


def test_benchmarks_start_ros_programs_without_a_mark(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv(MARK)
    assert ros_environment("http://localhost:11311", tmp_path)["ROS_MASTER_URI"] == "http://localhost:11311"
