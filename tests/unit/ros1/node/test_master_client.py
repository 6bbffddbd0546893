"""The nodes of one program share their connections to the master."""

from __future__ import annotations

import asyncio
import socket

import pytest

from rostether.errors import ConfigError, MasterUnreachableError
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node import master_client
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.xmlrpc_client import MAX_IDLE_CONNECTIONS


async def test_many_nodes_share_few_connections(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(master_client, "DEFAULT_TIMEOUT_S", 60.0)
    server = await MasterServer.start(port=0)
    nodes = [MasterClient(server.uri, f"/board{number}") for number in range(200)]
    # The master removes a node that does not answer.
    answering = await MasterServer.start(port=0)
    place = answering.uri
    try:
        await asyncio.gather(
            *(node.register_publisher(f"{node.caller_id}/topic", "a/B", place) for node in nodes)
        )
        assert len(server._server._connections) <= MAX_IDLE_CONNECTIONS
        publishers, _, _ = await nodes[0].system_state()
        assert len(publishers) == 200
        for node in nodes[:-1]:
            await node.close()
            await node.close()
        assert await nodes[-1].get_pid()
    finally:
        for node in nodes:
            await node.close()
        await server.close()
        await answering.close()
    assert not master_client._Connections._open[asyncio.get_running_loop()]


async def test_a_closed_client_connects_again() -> None:
    server = await MasterServer.start(port=0)
    master = MasterClient(server.uri, "/node")
    for _ in range(2):
        assert await master.get_pid()
        await master.close()
    await server.close()


async def test_a_call_waits_for_a_connection_within_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(master_client, "DEFAULT_TIMEOUT_S", 0.05)
    hung = socket.create_server(("127.0.0.1", 0))
    uri = f"http://127.0.0.1:{hung.getsockname()[1]}"
    master = MasterClient(uri, "/node")
    calls = [asyncio.ensure_future(master.get_pid()) for _ in range(MAX_IDLE_CONNECTIONS)]
    await asyncio.sleep(0)
    with pytest.raises(MasterUnreachableError, match="does not answer; check whether it hangs"):
        await master.get_pid()
    for call in calls:
        call.cancel()
    await asyncio.wait(calls)
    await master.close()
    hung.close()


def test_an_invalid_uri_is_refused_at_once() -> None:
    with pytest.raises(ConfigError):
        MasterClient("ftp://x", "/node")
