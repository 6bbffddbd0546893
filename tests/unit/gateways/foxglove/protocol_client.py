"""A client of the Foxglove WebSocket protocol for tests, and a gateway on a graph in memory."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosedError
from websockets.typing import Subprotocol

from rostether.gateways.foxglove.gateway import DashboardParts, FoxgloveGateway
from rostether.gateways.foxglove.recordings import RecordingControl
from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.gateways.websocket.site import Site
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Graph
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.transports.web_boards import WebBoards

TIMEOUT_S = 60.0  # of waits for conditions, on a machine under load
STRING = "std_msgs/String"
BINARY_OPS = {1: "messageData", 2: "time", 3: "serviceCallResponse", 4: "fetchAssetResponse"}


class ProtocolClient:
    """Collects the server's messages, as dicts with an `op`."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.received: list[dict[str, Any]] = []
        self._wakeup = asyncio.Event()
        self._reading = asyncio.ensure_future(self._read())

    async def say(self, op: str, **fields: Any) -> None:
        await self.connection.send(json.dumps({"op": op, **fields}))

    async def send_binary(self, data: bytes) -> None:
        await self.connection.send(data)

    async def publish(self, channel_id: int, payload: bytes) -> None:
        await self.connection.send(struct.pack("<BI", 1, channel_id) + payload)

    async def call(
        self, service_id: int, payload: bytes, *, encoding: str = "ros1", call_id: int = 7
    ) -> None:
        name = encoding.encode()
        header = struct.pack("<BIII", 2, service_id, call_id, len(name))
        await self.connection.send(header + name + payload)

    def of(self, op: str) -> list[dict[str, Any]]:
        return [message for message in self.received if message["op"] == op]

    async def wait(
        self, op: str, suits: Callable[[dict[str, Any]], object] = lambda _: True
    ) -> dict[str, Any]:
        """Wait for a message with this op that meets a condition, and return it."""

        def find() -> dict[str, Any] | None:
            return next((each for each in self.of(op) if suits(each)), None)

        async with asyncio.timeout(TIMEOUT_S):
            while (found := find()) is None:
                if self._reading.done():
                    raise AssertionError(f"the connection has ended; heard {self.received}")
                self._wakeup.clear()
                await self._wakeup.wait()
        return found

    async def channel(self, topic: str, *, after: int = 0) -> dict[str, Any]:
        """Wait for a topic's first channel with a larger id, and return it."""

        def find(message: dict[str, Any]) -> list[dict[str, Any]]:
            return [each for each in message["channels"] if each["topic"] == topic and each["id"] > after]

        return find(await self.wait("advertise", find))[0]

    async def service(self, name: str) -> dict[str, Any]:
        def has(message: dict[str, Any]) -> bool:
            return any(each["name"] == name for each in message["services"])

        offered = (await self.wait("advertiseServices", has))["services"]
        return next(each for each in offered if each["name"] == name)

    async def wait_closed(self) -> int | None:
        await asyncio.wait_for(self._reading, TIMEOUT_S)
        return self.connection.close_code

    async def close(self) -> None:
        await self.connection.close()
        await self._reading

    async def _read(self) -> None:
        with contextlib.suppress(ConnectionClosedError):
            async for message in self.connection:
                self.received.append(json.loads(message) if isinstance(message, str) else _binary(message))
                self._wakeup.set()
        self._wakeup.set()


@dataclass
class Stage:
    """A gateway, its graph, and a robot's node."""

    gateway: FoxgloveGateway
    store: TypeStore
    network: MemoryNetwork
    robot: MemoryGraph
    reported: list[str]

    @property
    def connection_count(self) -> int:
        """How many connections are open, including plain requests."""
        return len(self.gateway._server._connections)

    @asynccontextmanager
    async def client(
        self, protocol: str = "foxglove.sdk.v1", **options: Any
    ) -> AsyncIterator[ProtocolClient]:
        url = f"ws://127.0.0.1:{self.gateway.port}{options.pop('path', '/')}"
        connection = await connect(
            url, subprotocols=[Subprotocol(protocol)], proxy=None, compression=None, max_size=None, **options
        )
        client = ProtocolClient(connection)
        try:
            await client.wait("serverInfo")
            yield client
        finally:
            await client.close()


@asynccontextmanager
async def stage(
    settings: FoxgloveSettings | None = None,
    network: MemoryNetwork | None = None,
    site: Site | None = None,
    join_teleop: Callable[[], Awaitable[Graph]] | None = None,
    recordings: RecordingControl | None = None,
    boards: WebBoards | None = None,
    **options: Any,
) -> AsyncIterator[Stage]:
    """Run a gateway on a free port."""
    network, store, reported = network or MemoryNetwork(), TypeStore(Registry()), list[str]()
    graph, robot = await network.join("/foxglove"), await network.join("/robot")
    try:
        async with FoxgloveGateway(
            graph,
            store,
            settings or FoxgloveSettings(port=0),
            report=lambda _, text: reported.append(text),
            dashboard=DashboardParts(site, join_teleop, recordings, boards),
            **options,
        ) as gateway:
            yield Stage(gateway, store, network, robot, reported)
    finally:
        await robot.close()
        await graph.close()


def _binary(data: bytes) -> dict[str, Any]:
    op = BINARY_OPS[data[0]]
    if op == "messageData":
        subscription_id, time_ns = struct.unpack_from("<IQ", data, 1)
        return {"op": op, "id": subscription_id, "time_ns": time_ns, "payload": data[13:]}
    if op == "time":
        return {"op": op, "time_ns": struct.unpack_from("<Q", data, 1)[0]}
    if op == "serviceCallResponse":
        service_id, call_id, length = struct.unpack_from("<III", data, 1)
        encoding = data[13 : 13 + length].decode()
        payload = data[13 + length :]
        return {"op": op, "service": service_id, "call": call_id, "encoding": encoding, "payload": payload}
    request_id, status, length = struct.unpack_from("<IBI", data, 1)
    error = data[10 : 10 + length].decode()
    return {"op": op, "request": request_id, "status": status, "error": error, "data": data[10 + length :]}


def text(stage: Stage, data: str) -> bytes:
    return stage.store.codec(STRING).encode({"data": data})


def string_type(stage: Stage) -> MessageType:
    return stage.store.registry.message_type(STRING)
