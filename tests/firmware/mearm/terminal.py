"""Terminals in a catkin workspace, after `eval "$(rostether env --first)"`."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sys
from collections.abc import AsyncIterator
from pathlib import Path

from programs import Peer
from unit.firmware.sketches import users_cache

EXAMPLE = Path(__file__).parents[3] / "examples" / "mearm"
_REMOVED_VARIABLES = ("ROS", "PYTEST", "PYTHONPATH")


class Terminals:
    """Types commands, each in a new terminal."""

    def __init__(self, workspace: Path, master_uri: str) -> None:
        self.workspace = workspace
        self._environment = {
            name: value for name, value in os.environ.items() if not name.startswith(_REMOVED_VARIABLES)
        } | {
            "PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin",
            "ROS_MASTER_URI": master_uri,
            "HOME": str(workspace.parent),
            "XDG_CACHE_HOME": users_cache(),
            "PYTHONUNBUFFERED": "1",
        }
        self._peers: list[Peer] = []

    async def start(self, command: str) -> Peer:
        """Type a command and leave it running."""
        process = await asyncio.create_subprocess_exec(
            "bash",
            "-c",
            f'eval "$(rostether env --first --shell bash)"\n{command}',
            cwd=self.workspace,
            env=self._environment,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            start_new_session=True,
        )
        peer = Peer(process)
        peer.reader = asyncio.create_task(peer.read())
        self._peers.append(peer)
        return peer

    async def type(self, command: str) -> str:
        """Type a command and wait until it has ended successfully; return its output."""
        peer = await self.start(command)
        text = await peer.finish(30.0)
        assert peer.process.returncode == 0, f"{command}:\n{text}"
        return text

    async def close(self) -> None:
        """End the commands that are still running, the last one first."""
        for peer in reversed(self._peers):
            await peer.stop()


@contextlib.asynccontextmanager
async def terminals(home: Path, master_uri: str) -> AsyncIterator[Terminals]:
    """Provide terminals in a workspace with the example."""
    workspace = home / "catkin_ws"
    shutil.copytree(EXAMPLE, workspace / "src")
    opened = Terminals(workspace, master_uri)
    try:
        yield opened
    finally:
        await opened.close()
