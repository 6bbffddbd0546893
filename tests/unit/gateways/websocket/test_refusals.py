from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from rostether.gateways.websocket import refusals
from rostether.gateways.websocket.connection import Connection
from rostether.gateways.websocket.refusals import Refusals
from rostether.gateways.websocket.server import WebSocketServer
from rostether.gateways.websocket.settings import ConnectionLimits, ServedProtocol, ServerSettings
from rostether.gateways.websocket.websocket_stream import WebSocketStream

UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
LOCAL = {"peername": ("127.0.0.1", 5000), "sockname": ("127.0.0.1", 9090)}


class Accepted(asyncio.Transport):
    """A connection with only its addresses."""

    def __init__(self, addresses: dict[str, Any]) -> None:
        super().__init__(addresses)
        self.is_aborted = False

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None: ...

    def write(self, data: bytes | bytearray | memoryview) -> None: ...

    def abort(self) -> None:
        self.is_aborted = True


class Door:
    """A server with one place, and the connections that were made to it."""

    def __init__(self, allow: tuple[str, ...] = (), *, places: int = 1) -> None:
        self.reported: list[str] = []
        limits = ConnectionLimits(clients=places, others=0, message_bytes=1000, unsent_bytes=1000)
        settings = ServerSettings(allow=allow)
        self.server = WebSocketServer(
            ServedProtocol("test"), settings, limits, WebSocketStream, self.reported.append
        )
        self.connections: list[Connection] = []

    def admits(self, addresses: dict[str, Any]) -> bool:
        connection, transport = Connection(self.server), Accepted(addresses)
        self.connections.append(connection)
        connection.connection_made(transport)
        return not transport.is_aborted


@asynccontextmanager
async def door(allow: tuple[str, ...] = (), *, places: int = 1) -> AsyncIterator[Door]:
    there = Door(allow, places=places)
    try:
        yield there
    finally:
        for connection in there.connections:
            connection.connection_lost(None)


async def test_networks_that_were_named_may_connect_and_this_machine() -> None:
    async with door(("192.168.1.0/24",), places=10) as there:
        assert there.admits({"peername": ("192.168.1.7", 5000), "sockname": ("192.168.1.2", 9090)})
        assert there.admits(LOCAL)
        assert not there.admits({"peername": ("10.0.0.1", 5000), "sockname": ("192.168.1.2", 9090)})
    assert there.reported == [
        "refused 10.0.0.1:5000: 10.0.0.1 is not in the networks of --allow; add it there"
    ]


async def test_a_place_that_was_left_is_free() -> None:
    async with door() as there:
        assert there.admits(LOCAL)
        # A WebSocket keeps its place; other connections make room.
        there.connections[0].get_buffer(-1)[: len(UPGRADE)] = UPGRADE
        there.connections[0].buffer_updated(len(UPGRADE))
        assert not there.admits({"peername": ("::1", 5000), "sockname": ("::1", 9090)})
        assert there.reported == [
            "refused [::1]:5000: the limit of open connections (1) is reached; close another one"
        ]
        there.connections[0].connection_lost(None)
        assert there.admits(LOCAL)


async def test_a_connection_that_has_gone_already_takes_no_place() -> None:
    async with door() as there:
        assert not there.admits({})
        assert there.reported == ["refused a client: it has disconnected"]
        assert there.admits(LOCAL)


async def test_each_reason_is_reported_once_in_a_while_and_few_of_them() -> None:
    reported: list[str] = []
    quiet = Refusals(reported.append)
    for _ in range(2):
        for number in range(refusals.MAX_REASONS + 1):
            quiet.report("127.0.0.1:5000", f"page\n{number}")
    assert reported == [f"refused 127.0.0.1:5000: page {number}" for number in range(refusals.MAX_REASONS)]
    quiet._reported_until_s = 0.0
    quiet.report("127.0.0.1:5000", "page 0")
    assert reported[-1].endswith("page 0 (7 more since the last such line)")
