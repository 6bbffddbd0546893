from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from children import is_running
from rostether.mechanisms.backoff import Backoff
from rostether.platform.boot.part_process import PartProcess
from rostether.platform.boot.robot_file import Part
from waiting import until

# Reports that it is alive as services do, and its process id.
ALIVE = """
import os, socket, time
signs = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
print(os.getpid(), flush=True)
while True:
    signs.sendto(b"WATCHDOG=1", os.environ["NOTIFY_SOCKET"])
    time.sleep(0.05)
"""


class Lines(list[str]):
    """What a part printed, and what happened to it."""

    def report(self, name: str, line: str) -> None:
        assert name == "part"
        self.append(line)

    @property
    def pids(self) -> list[int]:
        return [int(line) for line in self if line.isdecimal()]


@asynccontextmanager
async def running(code: str, lines: Lines, *, watchdog_s: float = 60.0) -> AsyncIterator[asyncio.Task[None]]:
    process = PartProcess(
        Part("part", ("-c", code)),
        [sys.executable],
        dict(os.environ),
        lines.report,
        backoff=Backoff(first_s=0.01, limit_s=0.01),
        watchdog_s=watchdog_s,
    )
    task = asyncio.create_task(process.run())
    try:
        yield task
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def test_a_part_that_is_killed_starts_again_and_ends_with_us() -> None:
    lines = Lines()
    async with running(ALIVE, lines):
        await until(lambda: len(lines.pids) == 1)
        os.kill(lines.pids[0], signal.SIGKILL)
        await until(lambda: len(lines.pids) == 2)
        assert "ended (signal SIGKILL); restarts in 0 s" in lines
    assert not is_running(lines.pids[1])


async def test_a_part_that_hangs_is_ended_and_starts_again() -> None:
    lines = Lines()
    async with running(ALIVE, lines, watchdog_s=2.0):
        await until(lambda: lines.pids)
        os.kill(lines.pids[-1], signal.SIGSTOP)
        await until(lambda: len(lines.pids) >= 2)
    assert "has not responded for 2 s; ending it" in lines


async def test_a_part_that_never_reports_is_not_watched() -> None:
    lines = Lines()
    async with running("print('x' * 100_000); import time; time.sleep(600)", lines) as task:
        await until(lambda: sum(map(len, lines)) == 100_000)
        assert not task.done()


async def test_wrong_words_end_it() -> None:
    lines = Lines()
    async with running("raise SystemExit(2)", lines) as task:
        await task
    assert lines == ["its arguments are wrong: it does not start again; correct the file and restart"]


async def test_the_children_of_a_part_end_with_it() -> None:
    lines = Lines()
    code = (
        "import subprocess, time; print(subprocess.Popen(['sleep', '600']).pid, flush=True); time.sleep(600)"
    )
    async with running(code, lines):
        await until(lambda: bool(lines.pids))
    await until(lambda: not is_running(lines.pids[0]))
