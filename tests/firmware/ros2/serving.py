"""`rostether serve` as a process, with simulated boards that run real firmware."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from firmware.examples.stage import build_example
from programs import Peer, start_command

SKETCHES = Path(__file__).parent / "sketches"


async def sim_address(sketch: str | Path, kind: str, name: str) -> str:
    """Return the link address of a simulated board that runs a sketch, built once for all test processes."""
    built = await build_example(sketch, kind)
    return f"sim:{built.elf}?board={kind}&name={name}"


@asynccontextmanager
async def serving(
    *arguments: str, environment: Mapping[str, str] | None = None, on: Sequence[str] = ()
) -> AsyncIterator[Peer]:
    """Run `rostether serve` until the block ends."""
    peer = await start_command("serve", *arguments, environment=environment, on=on)
    try:
        yield peer
    finally:
        await peer.stop()
