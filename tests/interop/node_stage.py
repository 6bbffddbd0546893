"""A master with Debian's programs and with nodes of rostether."""

from __future__ import annotations

import asyncio
import contextlib
import time
import xmlrpc.client
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from interop.ros1_peers import Ros1Peers, debian_roscore
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import Ros1Graph, join_ros1

ON_BOTH_MASTERS = pytest.mark.parametrize("stage", ["rostether's master", "Debian's roscore"], indirect=True)


class Stage:
    """Nodes that join here leave at the end of the test."""

    def __init__(self, peers: Ros1Peers) -> None:
        self.peers = peers
        self._nodes: list[Ros1Graph] = []

    async def join(self, name: str) -> Ros1Graph:
        """Join as a node."""
        node = await join_ros1(
            name,
            environment=RosEnvironment.read({}).with_master(self.peers.master_uri),
            check_interval_s=0.1,
        )
        self._nodes.append(node)
        return node

    async def wait_for_rosout(self, *nodes: str) -> None:
        """Wait until the node /rosout of Debian's roscore has subscribed to the logs of these nodes."""
        await asyncio.to_thread(_wait_for_rosout, self.peers.master_uri, nodes)

    async def close(self) -> None:
        """Close all nodes."""
        for node in self._nodes:
            await node.close()


@contextlib.asynccontextmanager
async def stage_on(master: str, home: Path) -> AsyncIterator[Stage]:
    """Open a stage on one of the two masters."""
    async with contextlib.AsyncExitStack() as stack:
        if master == "rostether's master":
            server = await MasterServer.start(port=0)
            stack.push_async_callback(server.close)
            peers = Ros1Peers(server.uri, home)
            stack.push_async_callback(peers.close)
        else:
            peers = await stack.enter_async_context(debian_roscore(home))
        stage = Stage(peers)
        stack.push_async_callback(stage.close)
        yield stage


def _wait_for_rosout(master_uri: str, nodes: Sequence[str]) -> None:
    """Wait until the node /rosout, if it exists, is connected to these nodes."""

    def ask(uri: str, method: str, *arguments: str) -> Any:
        with xmlrpc.client.ServerProxy(uri) as server:
            return getattr(server, method)("/test", *arguments)

    if ask(master_uri, "lookupNode", "/rosout")[0] != 1:
        return
    deadline_s = time.monotonic() + 60
    for node in nodes:
        uri = ask(master_uri, "lookupNode", node)[2]
        while not any(row[4] == "/rosout" for row in ask(uri, "getBusInfo")[2]):
            assert time.monotonic() < deadline_s, f"/rosout never subscribed to {node}"
            time.sleep(0.01)
