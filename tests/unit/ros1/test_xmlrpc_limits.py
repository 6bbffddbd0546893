"""The XML-RPC server with slow, silent and many peers."""

from __future__ import annotations

import asyncio

import pytest

from rostether.ros1 import xmlrpc_server
from rostether.ros1.graph_limits import GraphLimits
from unit.ros1.xmlrpc_stage import RawClient, client_of, request, serving
from unit.transports.strangers import is_hung_up, stranger


async def test_a_silent_connection_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xmlrpc_server, "FIRST_BYTE_LIMIT_S", 0.1)
    async with serving({"ping": lambda: 1}) as server:
        silent = await RawClient.connect(server)
        assert await is_hung_up(silent.reader)
        await silent.close()


async def test_a_connection_that_has_sent_a_request_may_be_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xmlrpc_server, "FIRST_BYTE_LIMIT_S", 0.5)
    async with serving({"ping": lambda: 1}) as server:
        resting = await RawClient.connect(server)
        resting.writer.write(request("ping"))
        assert await resting.answer() == 1
        silent = await RawClient.connect(server)
        assert await is_hung_up(silent.reader)
        resting.writer.write(request("ping"))
        assert await resting.answer() == 1
        await silent.close()
        await resting.close()


@pytest.mark.parametrize("part", [b"POST / HTTP/1.1\r\n", request("ping")[:-1]], ids=["head", "body"])
async def test_a_request_that_arrives_too_slowly_is_aborted(part: bytes) -> None:
    async with serving({"ping": lambda: 1}, limits=GraphLimits(xmlrpc_request_s=0.1)) as server:
        slow = await RawClient.connect(server)

        async def trickle() -> None:
            for byte in part:
                slow.writer.write(bytes([byte]))
                await asyncio.sleep(0.02)

        trickling = asyncio.create_task(trickle())
        async with asyncio.timeout(60):
            assert await is_hung_up(slow.reader)
        assert not trickling.done()
        trickling.cancel()
        await slow.close()


async def test_a_header_without_end_is_refused() -> None:
    async with serving({}) as server:
        peer = await RawClient.connect(server)
        peer.writer.write(b"POST / HTTP/1.1\r\nX: " + b"a" * 200_000)
        answer = await peer.reader.read(100)
        assert answer == b"" or answer.startswith(b"HTTP/1.1 4")
        await peer.close()


async def test_connections_of_one_address_replace_only_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xmlrpc_server, "is_loopback", lambda host: host != "127.0.0.2")
    async with (
        serving({"ping": lambda: 1}, limits=GraphLimits(xmlrpc_connections_per_host=1)) as server,
        client_of(server) as friend,
    ):
        assert await friend.call("ping") == 1
        async with stranger(server.port) as (first, writer), stranger(server.port):
            assert await is_hung_up(first)
            assert await friend.call("ping") == 1
            assert len(server._connections) == 2
            writer.close()


@pytest.mark.parametrize(
    ("head", "status"),
    [
        (b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n", b"405"),
        (
            b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/plain\r\nContent-Length: 0\r\n\r\n",
            b"415",
        ),
        (
            b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/x-www-form-urlencoded\r\n"
            b"Content-Length: 0\r\n\r\n",
            b"415",
        ),
        (b"POST / HTTP/1.1\r\nHost: localhost\r\nOrigin: http://evil\r\nContent-Length: 0\r\n\r\n", b"403"),
        (b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n", b"413"),
    ],
    ids=["method", "plain text", "form", "web page", "body"],
)
async def test_illegal_requests_are_refused(head: bytes, status: bytes) -> None:
    async with serving({}) as server:
        peer = await RawClient.connect(server)
        peer.writer.write(head)
        assert (await peer.reader.readexactly(12)).split()[1] == status
        await peer.reader.read()
        await peer.close()
