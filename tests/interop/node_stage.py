"""A master, Debian's programs around it, and nodes of ours on it."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from interop.ros1_peers import Ros1Peers, debian_roscore
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import Ros1Graph, join_ros1

ON_BOTH_MASTERS = pytest.mark.parametrize("stage", ["our master", "Debian's roscore"], indirect=True)


class Stage:
    """Nodes that join here leave at the end of the test."""

    def __init__(self, peers: Ros1Peers) -> None:
        self.peers = peers
        self._nodes: list[Ros1Graph] = []

    async def join(self, name: str) -> Ros1Graph:
        """Join as a node."""
        node = await join_ros1(
            name, master_uri=self.peers.master_uri, environment=RosEnvironment.read({}), check_interval_s=0.1
        )
        self._nodes.append(node)
        return node

    async def close(self) -> None:
        """Leave with every node."""
        for node in self._nodes:
            await node.close()


@contextlib.asynccontextmanager
async def stage_on(master: str, home: Path) -> AsyncIterator[Stage]:
    """Set a stage on one of both masters."""
    async with contextlib.AsyncExitStack() as stack:
        if master == "our master":
            server = await MasterServer.start(port=0)
            stack.push_async_callback(server.close)
            peers = Ros1Peers(server.uri, home)
            stack.push_async_callback(peers.close)
        else:
            peers = await stack.enter_async_context(debian_roscore(home))
        stage = Stage(peers)
        stack.push_async_callback(stage.close)
        yield stage
