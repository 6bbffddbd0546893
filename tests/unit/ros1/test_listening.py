from __future__ import annotations

import asyncio
import errno
import os

import pytest

from rostether.errors import GraphError
from rostether.ros1 import listening
from rostether.ros1.listening import port_of, start_servers
from rostether.transports import sockets
from rostether.transports.sockets import close_servers


async def test_all_hosts_have_the_same_port() -> None:
    servers = await start_servers(asyncio.Protocol, ["127.0.0.1", "127.0.0.2"], 0)
    assert [server.sockets[0].getsockname()[1] for server in servers] == [port_of(servers)] * 2
    await close_servers(servers)


async def test_a_cancelled_start_closes_the_servers_that_listen(monkeypatch: pytest.MonkeyPatch) -> None:
    start = sockets.start_server
    started: list[asyncio.Server] = []
    reached = asyncio.Event()

    async def start_only_one(
        make_protocol: type[asyncio.Protocol], address: str, port: int, *, accepted_at_once: int
    ) -> asyncio.Server:
        if started:
            reached.set()
            await asyncio.Event().wait()
        started.append(await start(make_protocol, address, port, accepted_at_once=accepted_at_once))
        return started[0]

    monkeypatch.setattr(listening, "start_server", start_only_one)
    starting = asyncio.create_task(start_servers(asyncio.Protocol, ["127.0.0.1", "127.0.0.2"], 0))
    await reached.wait()
    starting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await starting
    assert not started[0].sockets


async def test_a_reserved_port_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    async def refuse(*_arguments: object, **_options: object) -> asyncio.Server:
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(listening, "start_server", refuse)
    with pytest.raises(GraphError, match=r"port 80 of 127\.0\.0\.1 is reserved .* choose one above 1023"):
        await start_servers(asyncio.Protocol, ["127.0.0.1"], 80)
