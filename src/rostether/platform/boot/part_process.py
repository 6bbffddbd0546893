"""Keeps one part of a robot running: starts it again when it ends, and ends it when it hangs."""

from __future__ import annotations

import asyncio
import shutil
import signal
import socket
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.program import signal_group
from rostether.platform.boot.robot_file import Part

# The same as in the systemd units: a part whose event loop is blocked for this time is killed and restarted.
_WATCHDOG_S = 20.0
# How long a part may take to end. systemd waits 10 s for all parts together.
END_LIMIT_S = 8.0
# A part that ran for this time has started successfully: the restart delay is short again.
SETTLED_S = 30.0
# The exit code of a command with wrong arguments: a restart would not help.
_EXIT_USAGE = 2
# A longer line of output is reported in pieces, because it must not fill the memory.
MAX_LINE_BYTES = 1 << 16


class PartProcess:
    """Runs `command` with the part's arguments; `report` gets its output lines and its restarts."""

    def __init__(
        self,
        part: Part,
        command: Sequence[str],
        environ: Mapping[str, str],
        report: Callable[[str, str], None],
        *,
        backoff: Backoff | None = None,
        watchdog_s: float = _WATCHDOG_S,
    ) -> None:
        self.part = part
        self._command = [*command, *part.words]
        self._environ = environ
        self._report = report
        self._backoff = backoff if backoff is not None else Backoff(first_s=1.0, limit_s=30.0)
        self._watchdog_s = watchdog_s
        self._last_notification_s: float | None = None

    async def run(self) -> None:
        """Keep the part running until canceled; then end it. Returns if its arguments are wrong."""
        loop = asyncio.get_running_loop()
        while True:
            started_s = loop.time()
            code = await self._run_once()
            if code == _EXIT_USAGE:
                self._report(
                    self.part.name,
                    "its arguments are wrong: it does not start again; correct the file and restart",
                )
                return
            if loop.time() - started_s > SETTLED_S:
                self._backoff.reset()
            delay_s = self._backoff.next_delay_s()
            self._report(self.part.name, f"ended ({_exit_text(code)}); restarts in {delay_s:.0f} s")
            await asyncio.sleep(delay_s)

    async def _run_once(self) -> int:
        # setpriv: the kernel ends the part if this process is killed.
        guard = [program, "--pdeathsig", "INT"] if (program := shutil.which("setpriv")) else []
        self._last_notification_s = None
        with (
            tempfile.TemporaryDirectory(prefix="rostether-up-", ignore_cleanup_errors=True) as folder,
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notifications,
        ):
            address = f"{folder}/notify"
            notifications.setblocking(False)
            notifications.bind(address)
            process = await asyncio.create_subprocess_exec(
                *guard,
                *self._command,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.STDOUT,
                limit=MAX_LINE_BYTES,
                env={
                    **self._environ,
                    "NOTIFY_SOCKET": address,
                    "WATCHDOG_USEC": str(round(self._watchdog_s * 1e6)),
                    "PYTHONUNBUFFERED": "1",
                },
                # Only this process receives Ctrl-C; it ends the parts.
                start_new_session=True,
            )
            loop = asyncio.get_running_loop()
            loop.add_reader(notifications, self._record_notifications, notifications)
            watching = asyncio.create_task(self._watch(process))
            try:
                await self._pass_lines(process)
                return await process.wait()
            finally:
                watching.cancel()
                loop.remove_reader(notifications)
                await asyncio.shield(_end(process))

    async def _pass_lines(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        while True:
            try:
                line = await process.stdout.readuntil(b"\n")
            except asyncio.IncompleteReadError as error:
                line = error.partial
                if not line:
                    return
            except asyncio.LimitOverrunError as error:
                line = await process.stdout.read(error.consumed)
            self._report(self.part.name, line.decode("utf-8", "replace").rstrip("\n"))

    def _record_notifications(self, notifications: socket.socket) -> None:
        with suppress(BlockingIOError):
            while True:
                notifications.recv(256)
                self._last_notification_s = asyncio.get_running_loop().time()

    async def _watch(self, process: asyncio.subprocess.Process) -> None:
        loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(self._watchdog_s / 4)
            # A part without watchdog reports, such as a command that only prints, is not watched.
            last_s = self._last_notification_s
            if last_s is not None and loop.time() - last_s > self._watchdog_s:
                self._report(self.part.name, f"has not responded for {self._watchdog_s:.0f} s; ending it")
                signal_group(process, signal.SIGKILL)
                return


async def _end(process: asyncio.subprocess.Process) -> None:
    signal_group(process, signal.SIGINT)
    with suppress(TimeoutError):
        async with asyncio.timeout(END_LIMIT_S):
            await process.wait()
    # Child processes of the part may still run: end them, too.
    signal_group(process, signal.SIGKILL)
    await process.wait()


def _exit_text(code: int) -> str:
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
