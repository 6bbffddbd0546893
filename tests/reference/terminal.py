"""Terminals of a reader: commands that are typed one after another, in one folder and environment."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import signal
import sys
import time
from pathlib import Path

from children import MARK
from unit.firmware.sketches import users_cache

TIMEOUT_S = 60.0


class Command:
    """One typed command, with its output so far."""

    def __init__(self, text: str, process: asyncio.subprocess.Process) -> None:
        self.text = text
        self.process = process
        self.printed = ""
        self._reader = asyncio.ensure_future(self._read())

    async def _read(self) -> None:
        assert self.process.stdout is not None
        while data := await self.process.stdout.read(65536):
            self.printed += data.decode(errors="replace")

    async def wait_for(self, pattern: str) -> str:
        """Wait until a pattern matches its output; return the match."""
        deadline_s = time.monotonic() + TIMEOUT_S
        while True:
            if found := re.search(pattern, self.printed, re.MULTILINE | re.DOTALL):
                return found[0]
            assert not self._reader.done(), f"`{self.text}` ended without {pattern!r}: {self.printed}"
            assert time.monotonic() < deadline_s, f"`{self.text}` never printed {pattern!r}: {self.printed}"
            await asyncio.sleep(0.01)

    async def finish(self) -> int:
        """Wait until it has ended; return its exit code."""
        async with asyncio.timeout(TIMEOUT_S):
            await self._reader
            return await self.process.wait()

    async def interrupt(self) -> None:
        """Press Ctrl-C, and wait for the end."""
        for number in (signal.SIGINT, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, number)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(TIMEOUT_S / 2):
                    await self._reader
                    await self.process.wait()
                    return


class Terminals:
    """Types commands as documents print them, in bash, after `eval "$(rostether env --first)"`."""

    def __init__(self, home: Path, master_uri: str) -> None:
        self.home = home
        self._state = home / ".state"
        self._state.mkdir(parents=True)
        self._cwd = home
        # `python` is the Python of the tests, which has no real rospy.
        self._environment = {
            MARK: os.environ[MARK],
            "PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin",
            "HOME": str(home),
            "XDG_CACHE_HOME": users_cache(),
            "SHELL": "/bin/bash",
            "LANG": "C.UTF-8",
            "PYTHONUNBUFFERED": "1",
            "ROS_MASTER_URI": master_uri,
            "ROS_HOME": str(home / ".ros"),
        }
        self._left_running: list[Command] = []

    async def start(self) -> None:
        """Open the shell."""
        await self.type('eval "$(rostether env --first)"')

    async def type(self, command: str) -> str:
        """Type a command that must succeed; return its output. The next command starts in its folder."""
        saved = f"{command}\ncode=$?; pwd > {self._state}/cwd; env -0 > {self._state}/env; exit $code"
        running = await self._start(saved, command)
        code = await running.finish()
        assert code == 0, f"`{command}` gave {code}: {running.printed}"
        assert "Traceback" not in running.printed, running.printed
        self._cwd = Path((self._state / "cwd").read_text().rstrip("\n"))
        entries = (self._state / "env").read_text().split("\0")
        self._environment = dict(each.split("=", 1) for each in entries if "=" in each)
        return running.printed

    async def leave_running(self, command: str) -> Command:
        """Type a command in a new terminal, and leave it running."""
        running = await self._start(f"exec {command}", command)
        self._left_running.append(running)
        return running

    async def close(self) -> None:
        """Press Ctrl-C in every terminal, the last first."""
        for running in reversed(self._left_running):
            await running.interrupt()

    async def _start(self, script: str, command: str) -> Command:
        process = await asyncio.create_subprocess_exec(
            "/bin/bash",
            "-c",
            script,
            cwd=self._cwd,
            env=self._environment,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            start_new_session=True,
        )
        return Command(command, process)
