"""A rosbridge server on the graph in memory, and plain WebSocket clients of it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

from rostether.gateways.rosbridge.server import RosbridgeServer
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

TIMEOUT_S = 60.0


class WebClient:
    """A client that sends operations, and receives one message at a time."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection

    async def say(self, op: str, **fields: Any) -> None:
        await self.connection.send(json.dumps({"op": op, **fields}))

    async def receive(self, op: str | None = None) -> dict[str, Any]:
        """Return the next message; if `op` is given, the message must have it."""
        async with asyncio.timeout(TIMEOUT_S):
            message: dict[str, Any] = json.loads(await self.connection.recv())
        assert op is None or message["op"] == op, message
        return message

    async def settled(self) -> list[dict[str, Any]]:
        """Wait until all sent operations are handled; return the messages received meanwhile."""
        await self.say("call_service", service="/settled", id="settled")
        received = []
        while (message := await self.receive()).get("id") != "settled":
            received.append(message)
        return received


class World:
    """A graph with a node of the test, and a server with its log."""

    def __init__(self, network: MemoryNetwork, node: MemoryGraph, server: RosbridgeServer) -> None:
        self.network = network
        self.graph = TypedGraph(node, TypeStore(Registry()))
        self.server = server
        self.log: list[tuple[Level, str]] = []

    @property
    def warnings(self) -> list[str]:
        return [text for level, text in self.log if level >= Level.WARN]

    @asynccontextmanager
    async def client(self, path: str = "", **options: Any) -> AsyncIterator[WebClient]:
        async with connect(f"ws://127.0.0.1:{self.server.port}{path}", **options) as connection:
            yield WebClient(connection)

    async def wait_until_all_left(self) -> None:
        counts = aiter(self.graph.messages("/client_count"))
        while (await anext(counts)).data:
            pass
        await counts.aclose()


@asynccontextmanager
async def world(
    settings: RosbridgeSettings | None = None, *, store: TypeStore | None = None, **options: Any
) -> AsyncIterator[World]:
    """Serve the graph in memory with rosbridge on a free port."""
    network = MemoryNetwork()
    graph = await network.join("/rosbridge_websocket")
    node = await network.join("/other")
    log: list[tuple[Level, str]] = []
    server = RosbridgeServer(
        graph,
        store or TypeStore(Registry()),
        settings or RosbridgeSettings(host="127.0.0.1", port=0),
        report=lambda level, text: log.append((level, text)),
        **options,
    )
    await server.start()
    there = World(network, node, server)
    there.log = log
    try:
        yield there
    finally:
        await server.close()
        await node.close()
        await graph.close()
