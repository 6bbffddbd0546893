"""Boards that web pages connect: the real server, bridge and device; the page is a WebSocket client."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial

import pytest
from msgspec.structs import replace
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus
from websockets.typing import Origin

from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Links, Supervisor
from rostether.device.device import Device
from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.transports.address import WebAddress
from rostether.transports.memory import MemoryTransport, memory_pair
from rostether.transports.opening import listen
from rostether.transports.web_boards import WebBoards
from unit.bridge.nodes import STORE, text
from unit.gateways.foxglove.protocol_client import Stage, stage
from waiting import until

STRING = STORE.registry.message_type("std_msgs/String")
SETTINGS = FoxgloveSettings(port=0)


class Page:
    """A client that acts like the page: its port is the other end of a device's line."""

    def __init__(self, socket: ClientConnection, port: MemoryTransport) -> None:
        self._socket = socket
        self._port = port
        self._sending: set[asyncio.Task[None]] = set()
        self._written_bytes = 0
        self.reading = asyncio.ensure_future(self._read())

    async def connect(self, name: str) -> None:
        hello = {"op": "connect", "name": name, "key": f"key-of-{name}", "baud": 115200}
        await self._socket.send(json.dumps(hello))
        self._port.start(self)

    def data_received(self, data: bytes) -> None:
        self._sending.add(asyncio.ensure_future(self._socket.send(data)))

    def connection_lost(self, _: object) -> None:
        """Do nothing: the test ends."""

    def pause_writing(self) -> None:
        """Do nothing: the test sends little."""

    def resume_writing(self) -> None:
        """Do nothing: the test sends little."""

    async def _read(self) -> None:
        async for message in self._socket:
            if isinstance(message, bytes):
                self._port.write(message)
                self._written_bytes += len(message)
                await self._socket.send(json.dumps({"op": "written", "bytes": self._written_bytes}))


@asynccontextmanager
async def page_of(there: Stage, device_name: str) -> AsyncIterator[Device]:
    """A page that connects a device, until the end of the block."""
    host_end, port = memory_pair()
    async with (
        connect(f"ws://127.0.0.1:{there.gateway.port}/serial", proxy=None) as socket,
        Device(host_end, store=STORE) as device,
    ):
        page = Page(socket, port)
        await page.connect(device_name)
        yield device
        page.reading.cancel()


@asynccontextmanager
async def bridge(there: Stage, boards: WebBoards) -> AsyncIterator[Supervisor]:
    supervisor = Supervisor(
        there.network.join,
        STORE,
        settings=BridgeSettings(grace_s=30.0),
        links=Links(listen=partial(listen, web_boards=boards)),
    )
    await supervisor.start([WebAddress()])
    try:
        yield supervisor
    finally:
        await supervisor.close()


async def test_two_pages_connect_boards_and_one_comes_back_under_its_name() -> None:
    boards = WebBoards()
    received: list[bytes] = []
    async with stage(SETTINGS, boards=boards) as there, bridge(there, boards) as supervisor:
        await there.robot.subscribe("/chatter", STRING, received.extend)
        async with page_of(there, "arm"):
            for _ in range(2):
                async with page_of(there, "uno") as device:
                    chatter = device.publisher("chatter", "std_msgs/String")
                    await device.wait_connected(30.0)
                    received.clear()
                    await until(lambda: chatter.publish(data="hello") and received)  # noqa: B023 - awaited here
                    assert set(received) == {text("hello")}
                    names = [view.node for view in supervisor.boards()]
                    assert names == ["/web_arm", "/web_uno"]


async def refused(there: Stage, query: str, origin: str | None) -> int:
    """Return the status of a handshake; 101 if it is accepted."""
    url = f"ws://127.0.0.1:{there.gateway.port}/serial{query}"
    try:
        async with connect(url, proxy=None, origin=Origin(origin) if origin is not None else None):
            return 101
    except InvalidStatus as error:
        return error.response.status_code


@pytest.mark.parametrize("token", ["", "full"])
async def test_only_own_pages_with_the_full_token_connect_boards(token: str) -> None:
    settings = replace(SETTINGS, token=token, view_token=token and "view")
    async with stage(settings, boards=WebBoards()) as there:
        own, query = f"http://127.0.0.1:{there.gateway.port}", f"?token={token}"
        assert await refused(there, query, own) == 101
        assert await refused(there, query, None) == 101
        assert await refused(there, query, "https://evil.example") == 403
        # It may view the graph, but not connect boards.
        assert await refused(there, query, "https://app.foxglove.dev") == 403
        if token:
            assert await refused(there, "?token=view", own) == 403
            assert await refused(there, "", own) == 403
            async with there.client(path="/?token=view") as viewer:
                assert viewer.of("serverInfo")[0]["metadata"]["features"] == ""
            async with there.client(path="/?token=full") as client:
                assert client.of("serverInfo")[0]["metadata"]["features"] == "serial"


async def test_a_gateway_without_boards_has_no_such_path() -> None:
    async with stage(SETTINGS) as there:
        assert await refused(there, "", None) == 404
