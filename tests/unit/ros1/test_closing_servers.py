"""Connections that arrive while a server closes."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Awaitable, Callable

import pytest

from rostether.errors import GraphError
from rostether.ros1.node.tcpros_listener import TcprosListener
from rostether.ros1.xmlrpc_server import XmlRpcServer
from rostether.transports.address import TcpAddress
from rostether.transports.tcp import TcpListener
from rostether.transports.transport import Transport


@pytest.mark.parametrize("turns", range(5))
async def test_connections_that_arrive_while_it_closes_are_ended(turns: int) -> None:
    """asyncio needs a few turns of its loop from accepting a connection to its first callback."""
    loop = asyncio.get_running_loop()
    for start in (start_xmlrpc, start_tcpros, start_tcp):
        port, close = await start()
        with socket.create_connection(("127.0.0.1", port)) as peer:
            peer.setblocking(False)
            for _ in range(turns):
                await asyncio.sleep(0)
            await close()
            async with asyncio.timeout(60):
                with contextlib.suppress(ConnectionResetError):
                    assert await loop.sock_recv(peer, 1) == b""


async def start_xmlrpc() -> tuple[int, Callable[[], Awaitable[None]]]:
    server = XmlRpcServer({})
    await server.start()
    return server.port, server.close


async def start_tcpros() -> tuple[int, Callable[[], Awaitable[None]]]:
    def refuse(_fields: dict[str, str], _transport: asyncio.Transport) -> asyncio.Protocol:
        raise GraphError("nothing is offered here")

    listener = TcprosListener(refuse, refuse, lambda _level, _text: None)
    await listener.start(["127.0.0.1"])
    return listener.port, listener.close


async def start_tcp() -> tuple[int, Callable[[], Awaitable[None]]]:
    transports: list[Transport] = []
    listener = await TcpListener.start(TcpAddress("127.0.0.1", 0), transports.append)
    return int(listener.address.rpartition(":")[2]), listener.close
