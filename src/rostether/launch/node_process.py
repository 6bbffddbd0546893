"""One process of a launch: starts it, restarts it, and ends it with all its child processes.

Each process has its own session: Ctrl-C in the terminal reaches only the launch, which then ends the
processes. On Linux, a process also gets SIGTERM if the launch is killed.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
import shlex
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO

from msgspec import Struct

from rostether.errors import LaunchError
from rostether.graph.ports import Level
from rostether.launch.command_line import NodeCommand
from rostether.launch.plan import LaunchNode, Output
from rostether.mechanisms.text import write_failure

# As in roslaunch: a node may have to stop a robot.
SIGINT_LIMIT_S = 15.0
SIGTERM_LIMIT_S = 2.0

# Repeated restarts of a node that ends immediately must not keep a CPU busy.
_RESPAWN_PAUSE_S = 0.1

# The system reports only the end of children, so the other processes of a group are polled.
_GROUP_POLL_S = 0.02

# A killed group ends immediately, unless a driver blocks a process.
_KILL_LIMIT_S = 1.0
_SIGKILL = getattr(signal, "SIGKILL", signal.SIGTERM)

# Constants of Linux's prctl().
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36

# Loaded before any fork: the child must not load libraries.
_prctl = ctypes.CDLL(None).prctl if sys.platform == "linux" else None


class StopLimits(Struct, frozen=True):
    """The time limits for a process to end after SIGINT and after SIGTERM, before SIGKILL."""

    sigint_s: float = SIGINT_LIMIT_S
    sigterm_s: float = SIGTERM_LIMIT_S


class NodeProcess:
    """A node's process; `name` is its name in lines and log files, such as `arm/mover-2`.

    `logs` is the folder of the log files; `report` gets each line with its level.
    """

    def __init__(
        self,
        node: LaunchNode,
        command: NodeCommand,
        name: str,
        logs: Path,
        report: Callable[[Level, str], None],
        limits: StopLimits,
    ) -> None:
        self.node = node
        self.name = name
        self.exit_code: int | None = None
        self._command = command
        self._log = logs / f"{name.replace('/', '-')}.log"
        self._report = report
        self._limits = limits
        self._process: asyncio.subprocess.Process | None = None
        # The node's process group; None if it has no process left, because the number may then be reused.
        self._group: int | None = None

    async def start(self) -> None:
        """Start the process. Raises LaunchError if that fails."""
        words = [*self._command.words, f"__log:={self._log}"]
        try:
            self._command.folder.mkdir(parents=True, exist_ok=True)
            opened = self._open_output()
        except OSError as error:
            raise self._error(write_failure(error.filename, error)) from None
        try:
            with opened as output:
                await self._create(words, output)
        except OSError as error:
            raise self._error(
                f"cannot run {words[0]}: {error.strerror or error}; check the first line of the script and "
                "launch-prefix="
            ) from None
        self._report(Level.INFO, f"process[{self.name}]: started with pid [{self._group}]")

    async def _create(self, words: list[str], output: IO[bytes] | None) -> None:
        creating = asyncio.ensure_future(
            asyncio.create_subprocess_exec(
                *words,
                cwd=self._command.folder,
                env=self._command.environ,
                stdout=output,
                start_new_session=True,
                preexec_fn=_end_with_parent if sys.platform == "linux" else None,
            )
        )
        try:
            await asyncio.shield(creating)
        finally:
            # Even when canceled, so that `stop` finds the process.
            self._process = await creating
            self._group = self._process.pid

    async def supervise(self) -> None:
        """Wait for its end; with respawn=, restart it each time. Raises LaunchError."""
        while True:
            assert self._process is not None
            self.exit_code = await self._process.wait()
            await self._end_group()
            self._report_ended(self._process.pid)
            if not self.node.respawn:
                return
            await asyncio.sleep(max(_RESPAWN_PAUSE_S, self.node.respawn_delay_s))
            self._report(Level.INFO, f"[{self.name}] restarting process")
            await self.start()

    async def stop(self) -> None:
        """End the process and its child processes: SIGINT, then SIGTERM, then SIGKILL.

        Call it only after the end of `supervise`.
        """
        process = self._process
        if process is None:
            return
        steps = ((signal.SIGINT, self._limits.sigint_s), (signal.SIGTERM, self._limits.sigterm_s))
        for number, limit_s in steps:
            if process.returncode is not None:
                break
            _signal_group(process.pid, number)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(process.wait(), limit_s)
                break
            self._report(Level.WARN, f"[{self.name}] did not end within {limit_s:g} s of {number.name}")
        if process.returncode is None:
            _signal_group(process.pid, _SIGKILL)
            try:
                await asyncio.wait_for(process.wait(), _KILL_LIMIT_S)
            except TimeoutError:
                # Another user's process, as with launch-prefix="sudo", cannot be ended.
                self._report(Level.ERROR, f"[{self.name}] does not end; run: kill -9 {process.pid}")
        await self._end_group()

    async def _end_group(self) -> None:
        group = self._group
        if group is None:
            return
        for number, limit_s in ((signal.SIGTERM, self._limits.sigterm_s), (_SIGKILL, _KILL_LIMIT_S)):
            if not _signal_group(group, number):
                break
            deadline = asyncio.get_running_loop().time() + limit_s
            while _signal_group(group, 0) and asyncio.get_running_loop().time() < deadline:
                _reap(group)
                await asyncio.sleep(_GROUP_POLL_S)
        self._group = None

    def _open_output(self) -> contextlib.AbstractContextManager[IO[bytes] | None]:
        if self.node.output is Output.SCREEN:
            return contextlib.nullcontext()
        # The output before a restart stays in the log.
        mode = "ab" if self._process is not None else "wb"
        return self._log.with_name(f"{self._log.stem}-stdout.log").open(mode)

    def _error(self, text: str) -> LaunchError:
        return LaunchError(text, file=self.node.file, line=self.node.line)

    def _report_ended(self, pid: int) -> None:
        if self.exit_code == 0:
            self._report(Level.INFO, f"[{self.name}] process has finished cleanly")
            return
        words = shlex.join(self._command.words)
        self._report(
            Level.ERROR,
            f"[{self.name}] process has died [pid {pid}, exit code {self.exit_code}, cmd {words}]; "
            f"log files: {self._log.with_suffix('')}*.log",
        )


def adopt_orphans() -> None:
    """Become the parent of descendants whose own parent has ended, in order to reap them (Linux)."""
    if _prctl is not None:
        _prctl(_PR_SET_CHILD_SUBREAPER, 1)


def _reap(group: int) -> None:
    # A process that has ended stays in the group until its parent reads its exit code.
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-group, os.WNOHANG)[0]:
            pass


def _signal_group(group: int, number: int) -> bool:
    """Signal all processes of a group. Returns False if none is left, or if the system has no groups."""
    if sys.platform == "win32":
        # Windows has no process groups, and every signal ends a process immediately.
        if number:
            with contextlib.suppress(OSError):
                os.kill(group, number)
        return False
    try:
        os.killpg(group, number)
    except (ProcessLookupError, PermissionError):
        return False
    return True


def _end_with_parent() -> None:
    if _prctl is not None:
        _prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
