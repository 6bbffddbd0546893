"""The reports of a client's program."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

from interop_web.robot_stage import RobotStage
from programs import Peer

TIMEOUT_S = 60.0


def read_reports(peer: Peer) -> dict[str, Any]:
    """Return the result of each check; errors as texts."""
    found = [json.loads(line) for line in peer.lines if line.startswith('{"check"')]
    return {each["check"]: each.get("found", each.get("error")) for each in found}


async def wait_until(peer: Peer, condition: Callable[[], object]) -> None:
    """Wait for a condition; at the time limit, fail with the program's output."""
    try:
        async with asyncio.timeout(TIMEOUT_S):
            while not condition() and not (peer.reader_done and peer.process.returncode is not None):
                await asyncio.sleep(0.01)
    except TimeoutError:
        pass
    assert condition(), f"the condition never became true; the program printed:\n{peer.text}"


async def wait_until_served(stage: RobotStage, service: str) -> None:
    """Wait until the robot finds a client's service."""
    async with asyncio.timeout(TIMEOUT_S):
        while not await stage.is_served(service):
            await asyncio.sleep(0.01)


async def resume(peer: Peer) -> None:
    """Let a program that waits for a line continue."""
    assert peer.process.stdin is not None
    peer.process.stdin.write(b"go on\n")
    await peer.process.stdin.drain()
