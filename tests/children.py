"""Processes that tests start get the default signal handlers, and end with their test file.

An environment variable marks them. So they are found even if they run in other sessions, their
parents have ended, or the test process was killed.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import signal
import sys
from collections.abc import Generator
from pathlib import Path
from types import FrameType

import pytest

import warm_start

# Each test process adds its name to the value: "CONTROLLER.WORKER." marks what a worker has started.
MARK = warm_start.MARK
# Background processes of CI systems ignore the first two; a process under nohup ignores the third.
_OFTEN_IGNORED = ("SIGINT", "SIGQUIT", "SIGHUP")


def pytest_configure() -> None:
    """Give children the usual signals, and mark them. SIGTERM ends the tests as Ctrl-C does."""
    for name in _OFTEN_IGNORED:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_IGN:
            # With this handler, this process still ignores the signal, but its children do not: they would
            # inherit SIG_IGN, but inherit no handler.
            signal.signal(number, _ignore)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ[MARK] = f"{os.environ.get(MARK, '')}{secrets.token_hex(4)}."


def environment_of_session() -> dict[str, str]:
    """Return the environment of a process that a fixture of the whole session ends.

    The process is not killed after a test file. If the fixture does not end it, the controller of the test
    processes does.
    """
    if MARK not in os.environ:
        # There is no test process: a script or a benchmark starts the process, and ends it.
        return dict(os.environ)
    *controllers, _ = os.environ[MARK].rstrip(".").split(".")
    return {**os.environ, MARK: "".join(f"{each}." for each in controllers)}


def is_running(number: int) -> bool:
    """Return whether a process runs. A process whose parent has not read its exit code does not run."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(") ")[2][0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def _ignore(_number: int, _frame: FrameType | None) -> None:
    pass


def end_left_running() -> list[str]:
    """Kill what this test process, or a test process that it started, left running; return command lines.

    Only on Linux.
    """
    if sys.platform != "linux":
        return []
    mark = f"\0{MARK}={os.environ[MARK]}".encode()
    excluded = {os.getpid(), *warm_start.interpreter_pids()}
    ended = []
    for folder in Path("/proc").glob("[0-9]*"):
        # Other users' processes cannot be read. The environment of a zombie is empty.
        with contextlib.suppress(OSError):
            variables = b"\0" + (folder / "environ").read_bytes()
            if mark in variables and int(folder.name) not in excluded:
                command = (folder / "cmdline").read_bytes().rstrip(b"\0").replace(b"\0", b" ")
                os.kill(int(folder.name), signal.SIGKILL)
                ended.append(command.decode(errors="replace"))
    return ended


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None]:
    """End what the tests and fixtures of a file left running, and fail the last of these tests."""
    yield
    is_last = nextitem is None or nextitem.path != item.path
    if is_last and warm_start.has_started_programs() and (ended := end_left_running()):
        pytest.fail(f"{item.path.name} left running: {'; '.join(ended)}", pytrace=False)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish() -> None:
    """End what an interrupted test, or a test process that was killed, left running."""
    end_left_running()
