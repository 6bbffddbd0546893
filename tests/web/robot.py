"""A simulated board on a ROS master, and the dashboard beside it, each a process of `rostether`."""

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
from typing import Any

from interop.ros1_peers import free_port

PATIENCE_S = 60.0
POLL_S = 0.1


class Robot:
    """The board is there from the beginning; the dashboard comes and goes."""

    def __init__(self, home: Path) -> None:
        self._home = home
        self._master = f"http://127.0.0.1:{free_port()}"
        self._port = free_port()
        self._board: asyncio.subprocess.Process | None = None
        self._dashboard: asyncio.subprocess.Process | None = None

    @property
    def url(self) -> str:
        """The page's address."""
        return f"http://127.0.0.1:{self._port}/"

    async def start(self) -> None:
        """Start the board, then the dashboard."""
        # With its own page, which stays unused, the board publishes /diagnostics as other boards do.
        self._board = await self._run("demo", "--ros1")
        await self.start_dashboard()

    @property
    def master(self) -> str:
        """The address of the board's master."""
        return self._master

    async def start_dashboard(self, *options: str) -> None:
        """Start the dashboard, the second time at the same address, and wait until it answers."""
        port = str(self._port)
        recordings = str(self._home / "recordings")
        self._dashboard = await self._run(
            *("dashboard", "--port", port, "--no-open", "--ros1", "--master", self._master),
            *("--recordings", recordings, *options),
        )
        async with asyncio.timeout(PATIENCE_S):
            while not await asyncio.to_thread(self._answers):
                assert self._dashboard.returncode is None, "the dashboard has ended"
                await asyncio.sleep(POLL_S)

    async def kill_dashboard(self) -> None:
        """Let it go without a word."""
        await _end(self._dashboard, signal.SIGKILL)

    async def close(self) -> None:
        """End both."""
        await _end(self._dashboard, signal.SIGTERM)
        await _end(self._board, signal.SIGTERM)

    async def subscribed_topics(self) -> set[str]:
        """Return the topics that the dashboard's node subscribes, as the master knows them."""
        master = xmlrpc.client.ServerProxy(self._master)
        answer: Any = await asyncio.to_thread(master.getSystemState, "/test")
        _, _, (_, subscriptions, _) = answer
        return {topic for topic, nodes in subscriptions if any("dashboard" in node for node in nodes)}

    async def wait_subscribed(self, topic: str, *, wanted: bool) -> None:
        """Wait until the dashboard's node subscribes a topic, or does not any more."""
        async with asyncio.timeout(PATIENCE_S):
            while (topic in await self.subscribed_topics()) is not wanted:
                await asyncio.sleep(POLL_S)

    def _answers(self) -> bool:
        try:
            with urllib.request.urlopen(self.url, timeout=5) as answer:
                return bool(answer.status == 200)
        except (urllib.error.URLError, OSError):
            return False

    async def _run(self, *arguments: str) -> asyncio.subprocess.Process:
        return await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "rostether",
            *arguments,
            env=os.environ | {"ROS_MASTER_URI": self._master, "HOME": str(self._home)},
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.DEVNULL,
            start_new_session=True,
        )


async def _end(process: asyncio.subprocess.Process | None, number: signal.Signals) -> None:
    if process is not None and process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            process.send_signal(number)
        try:
            await asyncio.wait_for(process.wait(), PATIENCE_S)
        except TimeoutError:
            process.kill()
            await process.wait()
