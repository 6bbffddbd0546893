"""One connection to an XML-RPC server: order, end, and clients that do not read or never finish a request."""

from __future__ import annotations

import asyncio
import contextlib
import socket

import pytest

from rostether.ros1 import xmlrpc_server
from rostether.ros1.graph_limits import GraphLimits
from rostether.xmlrpc.http_message import HttpClientSide
from unit.ros1.xmlrpc_stage import RawClient, client_of, later, request, serving
from waiting import until


async def test_an_invalid_body_is_a_fault() -> None:
    async with serving({}) as server:
        raw = await RawClient.connect(server)
        raw.writer.write(HttpClientSide("localhost").send_request(b"<methodCall>"))
        with pytest.raises(Exception, match="cannot be read"):
            await raw.answer()
        await raw.close()


async def test_pipelined_requests_are_answered_in_order() -> None:
    async with serving({"later": later, "now": lambda x: x}) as server:
        raw = await RawClient.connect(server)
        raw.writer.write(request("later", 1) + request("now", 2) + request("later", 3) + request("now", 4))
        data = b""
        while data.count(b"</methodResponse>") < 4:
            data += await raw.reader.read(65536)
        order = [data.index(b"<int>%d</int>" % number) for number in (1, 2, 3, 4)]
        assert order == sorted(order)
        await raw.close()


async def test_a_client_that_closed_its_sending_side_still_gets_its_answer() -> None:
    async with serving({"now": lambda x: x}) as server:
        raw = await RawClient.connect(server)
        raw.writer.write(request("now", "x"))
        raw.writer.write_eof()
        assert await raw.answer() == "x"
        assert await raw.reader.read() == b""
        await raw.close()


async def test_a_method_ends_with_its_connection() -> None:
    began, cancelled = asyncio.Event(), asyncio.Event()

    async def hang() -> None:
        began.set()
        try:
            await asyncio.Event().wait()
        finally:
            cancelled.set()

    async with serving({"hang": hang}) as server:
        raw = await RawClient.connect(server)
        raw.writer.write(request("hang"))
        await began.wait()
        raw.writer.transport.abort()
        await asyncio.wait_for(cancelled.wait(), 60)
        await raw.close()


async def test_a_client_that_does_not_read_is_not_read_from() -> None:
    calls = 0

    def big() -> str:
        nonlocal calls
        calls += 1
        return "x" * 1_000_000

    async with serving({"big": big}) as server:
        raw = await RawClient.connect(server)
        raw.writer.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        raw.reader._transport.pause_reading()  # type: ignore[attr-defined]
        raw.writer.write(request("big") * 200)
        await until(lambda: calls)
        for _ in range(50):
            await asyncio.sleep(0.002)
        assert calls < 50
        raw.writer.transport.abort()
        await raw.close()


async def test_many_large_requests_cannot_fill_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros1.xmlrpc_server._LARGEST_AT_ONCE", 1)
    async with serving({"size": len}, limits=GraphLimits(body_bytes=1_000_000)) as server:
        begin = request("size", "x" * 900_000)[:-100]
        first = await RawClient.connect(server)
        first.writer.write(begin)
        async with asyncio.timeout(60):
            while sum(each.body_bytes for each in server._connections) < 800_000:
                await asyncio.sleep(0.002)
        second = await RawClient.connect(server)
        second.writer.write(begin)
        with contextlib.suppress(ConnectionError):
            assert await asyncio.wait_for(second.reader.read(), 60) == b"", "no room for it"
        first.writer.write(request("size", "x" * 900_000)[-100:])
        assert await first.answer() == 900_000
        await first.close()
        await second.close()


async def test_idle_connections_are_closed_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xmlrpc_server, "IDLE_TIMEOUT_S", 0.1)
    async with serving({"ping": lambda: 1}) as server:
        raw = await RawClient.connect(server)
        half = await RawClient.connect(server)
        half.writer.write(b"POST / HTTP/1.1\r\n")
        assert await asyncio.wait_for(raw.reader.read(), 60) == b""
        with contextlib.suppress(ConnectionError):
            assert await asyncio.wait_for(half.reader.read(), 60) == b""
        await raw.close()
        await half.close()


async def test_a_slow_method_is_not_idle(monkeypatch: pytest.MonkeyPatch) -> None:
    async def slow() -> int:
        await asyncio.sleep(1.0)
        return 7

    monkeypatch.setattr(xmlrpc_server, "IDLE_TIMEOUT_S", 0.5)
    async with serving({"slow": slow}) as server, client_of(server) as client:
        assert await client.call("slow") == 7
