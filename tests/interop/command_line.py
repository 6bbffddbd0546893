"""Our command line as its users run it: a process of its own."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Mapping, Sequence

from interop.ros1_peers import Peer


async def started(
    *arguments: str, environment: Mapping[str, str] | None = None, on: Sequence[str] = ()
) -> Peer:
    """Start our command line; what it prints is kept. `on` begins its command, see `machines`."""
    process = await asyncio.create_subprocess_exec(
        *on,
        sys.executable,
        *("-m", "rostether", *arguments),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        env={**os.environ, **(environment or {})},
        start_new_session=True,
    )
    peer = Peer(process)
    peer.reader = asyncio.ensure_future(peer.read())
    return peer
