"""A simulated board on a ROS master, and the dashboard, each a process of `rostether`."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
import urllib.error
import urllib.request
import xmlrpc.client
from pathlib import Path
from typing import Any, Self

from interop.ros1_peers import free_port

TIMEOUT_S = 60.0
POLL_S = 0.1


class Robot:
    """A board that runs for the whole test, and a dashboard that can be restarted."""

    def __init__(self, home: Path) -> None:
        self._home = home
        self._master = f"http://127.0.0.1:{free_port()}"
        self._port = free_port()
        self._board: asyncio.subprocess.Process | None = None
        self._dashboard: asyncio.subprocess.Process | None = None
        self._options: tuple[str, ...] = ()

    @property
    def url(self) -> str:
        """The page's address."""
        return f"http://127.0.0.1:{self._port}/"

    async def start(self) -> None:
        """Start the board, then the dashboard."""
        # The demo publishes /diagnostics only with its own page, which is not used here.
        self._board = await self._run("demo", "--board", "python", "--ros1")
        await self.start_dashboard()

    @property
    def master(self) -> str:
        """The address of the board's master."""
        return self._master

    async def start_dashboard(self, *options: str) -> None:
        """Start the dashboard, the second time on the same address, and wait until it answers."""
        self._options = options
        port = str(self._port)
        recordings = str(self._home / "recordings")
        self._dashboard = await self._run(
            *("dashboard", "--port", port, "--no-open", "--ros1", "--master", self._master),
            *("--recordings", recordings, *options),
        )
        await wait_for_page(self.url, self._dashboard)

    async def restore_dashboard(self) -> None:
        """Start the dashboard again if a test has ended it or set options."""
        if self._options or self._dashboard is None or self._dashboard.returncode is not None:
            await self.kill_dashboard()
            await self.start_dashboard()

    async def kill_dashboard(self) -> None:
        """Kill it, so that it cannot close its connections."""
        await end(self._dashboard, signal.SIGKILL)

    async def close(self) -> None:
        """End both."""
        await end(self._dashboard, signal.SIGTERM)
        await end(self._board, signal.SIGTERM)

    async def subscribed_topics(self) -> set[str]:
        """Return the topics to which the dashboard's node subscribes, from the master."""
        return await self._topics(1)

    async def wait_for_publication(self, topic: str, *, expected: bool) -> None:
        """Wait until the dashboard's node publishes a topic or, with `expected` false, does not."""
        async with asyncio.timeout(TIMEOUT_S):
            while (topic in await self._topics(0)) is not expected:
                await asyncio.sleep(POLL_S)

    async def _topics(self, kind: int) -> set[str]:
        with xmlrpc.client.ServerProxy(self._master) as master:
            answer: Any = await asyncio.to_thread(master.getSystemState, "/test")
        return {topic for topic, nodes in answer[2][kind] if any("dashboard" in node for node in nodes)}

    async def wait_for_subscription(self, topic: str, *, expected: bool) -> None:
        """Wait until the dashboard's node subscribes to a topic or, with `expected` false, does not."""
        async with asyncio.timeout(TIMEOUT_S):
            while (topic in await self.subscribed_topics()) is not expected:
                await asyncio.sleep(POLL_S)

    async def _run(self, *arguments: str) -> asyncio.subprocess.Process:
        return await run_rostether(self._home, self._master, *arguments)


class LaunchedRobot:
    """The processes of a launch file, with a master and a dashboard."""

    def __init__(self, home: Path, launch: Path) -> None:
        self._home = home
        self._launch = launch
        self._process: asyncio.subprocess.Process | None = None
        self.master = f"http://127.0.0.1:{free_port()}"
        self.url = f"http://127.0.0.1:{free_port()}/"

    async def __aenter__(self) -> Self:
        address = self.url.removeprefix("http://").rstrip("/")
        self._process = await run_rostether(
            self._home, self.master, "launch", str(self._launch), "--dashboard", address
        )
        await wait_for_page(self.url, self._process)
        return self

    async def __aexit__(self, *_: object) -> None:
        await end(self._process, signal.SIGTERM)


async def wait_for_page(url: str, process: asyncio.subprocess.Process) -> None:
    """Wait until a process serves its page."""
    async with asyncio.timeout(TIMEOUT_S):
        while not await asyncio.to_thread(_answers, url):
            assert process.returncode is None, "the dashboard has ended"
            await asyncio.sleep(POLL_S)


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=5) as answer:
            return bool(answer.status == 200)
    except (urllib.error.URLError, OSError):
        return False


async def run_rostether(home: Path, master: str, *arguments: str) -> asyncio.subprocess.Process:
    """Start a command of rostether that uses a master."""
    return await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rostether",
        *arguments,
        env=os.environ | {"ROS_MASTER_URI": master, "HOME": str(home)},
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.DEVNULL,
        start_new_session=True,
    )


async def end(process: asyncio.subprocess.Process | None, number: signal.Signals) -> None:
    """End a process with a signal, and wait until it has ended."""
    if process is not None and process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            process.send_signal(number)
        try:
            await asyncio.wait_for(process.wait(), TIMEOUT_S)
        except TimeoutError:
            process.kill()
            await process.wait()
