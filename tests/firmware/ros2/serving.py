"""`rostether serve` as its users run it: a process, with simulated boards that run real firmware."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path

from firmware.examples.stage import build_example
from interop.ros1_peers import Peer

SKETCHES = Path(__file__).parent / "sketches"


async def sim_address(sketch: str | Path, kind: str, name: str) -> str:
    """Return the link address of a simulated board that runs a sketch, built once for all test processes."""
    built = await build_example(sketch, kind)
    return f"sim:{built.elf}?board={kind}&name={name}"


@asynccontextmanager
async def serving(*arguments: str, environment: Mapping[str, str] | None = None) -> AsyncIterator[Peer]:
    """Run `rostether serve` as long as the block lasts; what it prints is kept."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "rostether", "serve", *arguments),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        env={**os.environ, **(environment or {})},
        start_new_session=True,
    )
    peer = Peer(process)
    peer.reader = asyncio.ensure_future(peer.read())
    try:
        yield peer
    finally:
        await peer.stop()
