"""Our long-running commands as processes of their own, as a user starts and stops them."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from interop.ros1_peers import Peer


@asynccontextmanager
async def started(*arguments: str, **environment: str) -> AsyncIterator[Peer]:
    """Run `rostether ARGUMENTS` with no ROS variables but those given; ended with SIGINT if it still runs."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("ROS")}
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rostether",
        *arguments,
        env=clean | {"PYTHONUNBUFFERED": "1"} | environment,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        start_new_session=True,
    )
    peer = Peer(process)
    peer.reader = asyncio.create_task(peer.read())
    try:
        yield peer
        await peer.stop()
        assert "Traceback" not in peer.text
    finally:
        await peer.stop(signal.SIGKILL)
