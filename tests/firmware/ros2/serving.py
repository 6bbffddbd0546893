"""`rostether serve` as its users run it: a process, with simulated boards that run real firmware."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from firmware.examples.stage import build_example
from interop.ros1_peers import Peer

SKETCHES = Path(__file__).parent / "sketches"


async def sim_address(sketch: str | Path, kind: str, name: str) -> str:
    """Return the link address of a simulated board that runs a sketch, built once for all test processes."""
    built = await build_example(sketch, kind)
    return f"sim:{built.elf}?board={kind}&name={name}"


async def started(
    *arguments: str, environment: Mapping[str, str] | None = None, on: Sequence[str] = ()
) -> Peer:
    """Start our command line; what it prints is kept. `on` begins its command, see `interop.machines`."""
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


@asynccontextmanager
async def serving(
    *arguments: str, environment: Mapping[str, str] | None = None, on: Sequence[str] = ()
) -> AsyncIterator[Peer]:
    """Run `rostether serve` as long as the block lasts."""
    peer = await started("serve", *arguments, environment=environment, on=on)
    try:
        yield peer
    finally:
        await peer.stop()
