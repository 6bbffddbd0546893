"""Controls the other process with rclpy, `rclpy_program`."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ros2_domains import own_domain

PROGRAM = Path(__file__).with_name("rclpy_program.py")
PEER_NAME = "/far/peer"


class RclpyPeer:
    """A node `/far/peer` in another process; each verb is a method of the program's `Peer`."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    @property
    def pid(self) -> int:
        """The process's id."""
        return self._process.pid

    async def ask(self, verb: str, **arguments: Any) -> Any:
        """Run a verb in the peer, and return its answer."""
        return await asyncio.to_thread(self._ask, {"verb": verb, **arguments})

    def wait_until_ready(self) -> None:
        """Wait for its first line."""
        self._read()

    def _ask(self, request: dict[str, Any]) -> Any:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        return self._read()

    def _read(self) -> Any:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise AssertionError(f"the peer ended with {self._process.wait(10)}")
        reply = json.loads(line)
        if "error" in reply:
            raise AssertionError(f"the peer reports: {reply['error']}")
        return reply["answer"]


@contextmanager
def rclpy_peer() -> Iterator[RclpyPeer]:
    """Run a peer on this process's domain."""
    own_domain()
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", str(PROGRAM), PEER_NAME.rpartition("/")[2]],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        peer = RclpyPeer(process)
        peer.wait_until_ready()
        yield peer
    finally:
        try:
            # It leaves the graph at the end of its input.
            process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate(timeout=60)
