"""Programs that tests start: rostether's command line, and other programs."""

from __future__ import annotations

import asyncio
import contextlib
import os
import pty
import select
import signal
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

# A busy machine may be five times slower than a quiet one.
TIMEOUT_S = 60.0

ROSTETHER = (sys.executable, "-m", "rostether")


# The report of a failed test has this number of last lines of each program.
SHOWN_LINES = 20


@dataclass(eq=False)
class Peer:
    """A running program; `lines` has its output so far, including standard error."""

    process: asyncio.subprocess.Process
    lines: list[str] = field(default_factory=list)
    reader: asyncio.Task[None] | None = None

    @property
    def text(self) -> str:
        """Return its output so far."""
        return "\n".join(self.lines)

    async def read(self) -> None:
        """Collect its output until the end."""
        assert self.process.stdout is not None
        async for line in self.process.stdout:
            self.lines.append(line.decode(errors="replace").rstrip("\n"))

    async def wait_for(
        self, condition: Callable[[list[str]], bool] | str, timeout_s: float = TIMEOUT_S
    ) -> None:
        """Wait until its output contains a text or meets a condition."""
        holds = (
            (lambda lines: any(condition in line for line in lines))
            if isinstance(condition, str)
            else condition
        )
        deadline = time.monotonic() + timeout_s
        while not holds(self.lines):
            if time.monotonic() > deadline or (self.process.returncode is not None and self.reader_done):
                raise AssertionError(f"peer never printed {condition!r}; it printed:\n{self.text}")
            await asyncio.sleep(0.01)

    @property
    def reader_done(self) -> bool:
        """Return whether its output has ended."""
        return self.reader is None or self.reader.done()

    async def finish(self, timeout_s: float = TIMEOUT_S) -> str:
        """Wait until it ends by itself; return its output."""
        try:
            await asyncio.wait_for(self.process.wait(), timeout_s)
        except TimeoutError:
            raise AssertionError(f"peer did not end within {timeout_s} s; it printed:\n{self.text}") from None
        if self.reader is not None:
            await self.reader
        return self.text

    async def stop(self, signal_number: int = signal.SIGINT) -> None:
        """End it and all processes that it started: first with a signal, then with SIGKILL."""
        # roslaunch starts its nodes in other process groups; they would outlive it and keep its output open.
        groups = _descendants(self.process.pid)
        for number in (signal_number, signal.SIGTERM, signal.SIGKILL):
            if self.process.returncode is not None:
                break
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, number)
            deadline_s = time.monotonic() + (TIMEOUT_S if number == signal_number else TIMEOUT_S / 4)
            # `wait` would also wait for programs that have inherited its output.
            while self.process.returncode is None and time.monotonic() < deadline_s:
                await asyncio.sleep(0.01)
        for group in groups:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(group, signal.SIGKILL)
        if self.reader is not None:
            # A program that it left running may keep the output open.
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.reader, TIMEOUT_S / 4)


_peers: weakref.WeakKeyDictionary[Peer, str] = weakref.WeakKeyDictionary()


def _descendants(pid: int) -> set[int]:
    """Return the ids of a process and all its descendants."""
    found: set[int] = set()
    pending = [pid]
    while pending:
        parent = pending.pop()
        found.add(parent)
        # A process and a thread may end at any moment.
        with contextlib.suppress(OSError):
            for thread in Path(f"/proc/{parent}/task").iterdir():
                with contextlib.suppress(OSError):
                    pending += map(int, (thread / "children").read_text().split())
    return found


async def start_program(*command: str, environment: Mapping[str, str], has_stdin: bool = False) -> Peer:
    """Start a program as the leader of a process group, and collect its output.

    With `has_stdin`, its standard input is a pipe.
    """
    process = await asyncio.create_subprocess_exec(
        *command,
        env=environment,
        stdin=asyncio.subprocess.PIPE if has_stdin else asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        start_new_session=True,
        limit=1 << 22,
    )
    peer = Peer(process)
    _peers[peer] = Path(command[0]).name + " " + " ".join(command[1:])
    peer.reader = asyncio.create_task(peer.read())
    return peer


def last_outputs() -> list[tuple[str, str]]:
    """Return the command and the last lines of every program that a test or its fixtures use."""
    return [
        (f"{command[:200]} printed last", "\n".join(peer.lines[-SHOWN_LINES:]))
        for peer, command in _peers.items()
    ]


async def start_command(
    *arguments: str, environment: Mapping[str, str] | None = None, on: Sequence[str] = ()
) -> Peer:
    """Start `rostether ARGUMENTS`; the caller stops it. `on` is a command prefix, see `machines`."""
    return await start_program(*on, *ROSTETHER, *arguments, environment={**os.environ, **(environment or {})})


@asynccontextmanager
async def started(*arguments: str, **environment: str) -> AsyncIterator[Peer]:
    """Run `rostether ARGUMENTS` with only the given ROS variables; at the end of the block, it gets
    SIGINT.
    """
    clean = {name: value for name, value in os.environ.items() if not name.startswith("ROS")}
    peer = await start_program(
        *ROSTETHER, *arguments, environment=clean | {"PYTHONUNBUFFERED": "1"} | environment
    )
    try:
        yield peer
        await peer.stop()
        assert "Traceback" not in peer.text
    finally:
        await peer.stop(signal.SIGKILL)


@contextmanager
def running(
    *arguments: str,
    ignores_sigint: bool = False,
    cwd: Path | None = None,
    stdin: int = subprocess.DEVNULL,
    stdout: int = subprocess.PIPE,
    stderr: int = subprocess.PIPE,
    **environment: str,
) -> Iterator[subprocess.Popen[str]]:
    """Run `rostether ARGUMENTS`, for tests without asyncio; at the end of the block, it is killed."""

    def ignore() -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    process = subprocess.Popen(
        [*ROSTETHER, *arguments],
        env=os.environ | environment,
        cwd=cwd,
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        text=True,
        preexec_fn=ignore if ignores_sigint else None,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def read_until(process: subprocess.Popen[str], text: str) -> list[str]:
    """Return the lines of stdout up to the one that contains a text; fail if the process ends first."""
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        lines.append(line.rstrip("\n"))
        if text in line:
            return lines
    errors = "" if process.stderr is None else process.stderr.read()
    raise AssertionError(f"it never printed {text!r}: {lines}; {errors}")


class Terminal:
    """A pseudo-terminal of 80 columns with a rostether command.

    Its output is read continuously, because a command cannot write to a full terminal.
    """

    def __init__(self, leader: int, process: subprocess.Popen[str]) -> None:
        self.process = process
        self.seen = b""
        self._leader = leader
        self._is_closing = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def type(self, keys: bytes) -> None:
        """Press keys."""
        os.write(self._leader, keys)

    def wait_for(self, text: str) -> None:
        """Wait until the terminal has shown a text."""
        deadline_s = time.monotonic() + TIMEOUT_S
        while text.encode() not in self.seen:
            assert time.monotonic() < deadline_s, f"{text!r} not in {self.seen[-4000:]!r}"
            time.sleep(0.005)

    def close(self) -> None:
        """Stop reading."""
        self._is_closing.set()
        self._reader.join()

    def _read(self) -> None:
        # The system reports an error when the command has ended.
        with contextlib.suppress(OSError):
            while not self._is_closing.is_set():
                if select.select([self._leader], [], [], 0.05)[0]:
                    self.seen += os.read(self._leader, 65536)


@contextmanager
def in_terminal(*arguments: str, lines: int = 24, **environment: str) -> Iterator[Terminal]:
    """Run `rostether ARGUMENTS` in a terminal; at the end of the block, it is killed."""
    leader, follower = pty.openpty()
    variables: Any = {"COLUMNS": "80", "LINES": str(lines), "TERM": "xterm"} | environment
    try:
        with running(*arguments, stdin=follower, stdout=follower, stderr=follower, **variables) as process:
            os.close(follower)
            terminal = Terminal(leader, process)
            try:
                yield terminal
            finally:
                terminal.close()
    finally:
        os.close(leader)
