"""Runs zenoh-ros2-sdk in a separate process."""

from __future__ import annotations

import asyncio
import importlib.util
import json
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

PEER = Path(__file__).parent / "peers" / "zenoh_sdk_peer.py"


def missing_sdk() -> str:
    """Return why zenoh-ros2-sdk cannot be used here, or an empty string."""
    return "" if importlib.util.find_spec("zenoh_ros2_sdk") else "zenoh-ros2-sdk is not installed (pip)"


class SdkPeer:
    """The process with zenoh-ros2-sdk. `received` has all messages of its subscribers, `received_on` those of
    each topic.
    """

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.received: list[dict[str, Any]] = []
        self.received_on: dict[str, list[dict[str, Any]]] = {}
        self._process = process
        self._answers: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._reading = asyncio.ensure_future(self._read())

    async def do(self, verb: str, name: str = "", **arguments: Any) -> dict[str, Any]:
        """Send a command, and wait until it is done."""
        assert self._process.stdin is not None
        line = json.dumps({"do": verb, "name": name, **arguments})
        self._process.stdin.write(line.encode() + b"\n")
        return await self.answer(verb)

    async def answer(self, verb: str, timeout_s: float = 60.0) -> dict[str, Any]:
        """Wait for the answer to a command."""
        async with asyncio.timeout(timeout_s):
            answer = await self._answers.get()
        assert answer.get("done") == verb, answer
        assert "error" not in answer, answer
        return answer

    async def close(self) -> None:
        """End the process."""
        if self._process.returncode is None:
            self._process.kill()
        await self._process.wait()
        await self._reading
        assert self._process.stdin is not None
        self._process.stdin.close()

    async def _read(self) -> None:
        assert self._process.stdout is not None
        async for line in self._process.stdout:
            if not line.startswith(b"{"):
                continue
            fields = json.loads(line)
            if "received" in fields:
                self.received.append(fields["fields"])
                self.received_on.setdefault(fields["received"], []).append(fields["fields"])
            else:
                self._answers.put_nowait(fields)


@asynccontextmanager
async def sdk_peer(
    port: int, home: Path, domain_id: int = 0, *, on: Sequence[str] = ()
) -> AsyncIterator[SdkPeer]:
    """Start it as a peer of the router at `port`; `on` is a command prefix, see `machines`."""
    process = await asyncio.create_subprocess_exec(
        *on,
        sys.executable,
        str(PEER),
        str(port),
        str(domain_id),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        env={"PATH": "/usr/bin:/bin", "HOME": str(home), "XDG_CACHE_HOME": str(home)},
        limit=1 << 24,
    )
    peer = SdkPeer(process)
    try:
        await peer.answer("start")
        yield peer
    finally:
        await peer.close()
