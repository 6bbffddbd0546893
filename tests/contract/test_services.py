"""Offering and calling services."""

from __future__ import annotations

import asyncio

import pytest

from contract.graphs import EMPTY, SET_BOOL, until
from rostether.errors import (
    GraphError,
    ServiceCallError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    SessionError,
    TypeMismatchError,
)
from rostether.graph.ports import JoinGraph
from rostether.msgdef.interface import ANY_MESSAGE, ServiceType

ANY_SERVICE = ServiceType("*", "*", ANY_MESSAGE, ANY_MESSAGE)


async def echo(request: bytes) -> bytes:
    return request + b"!"


async def test_a_call_is_answered(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    handle = await server.advertise_service("/switch", SET_BOOL, echo)
    assert handle.service == "/switch"
    for request in (b"", b"\x01", bytes(1 << 20)):
        assert await client.call_service("/switch", SET_BOOL, request, timeout_s=10.0) == request + b"!"
    assert await client.call_service("switch", ANY_SERVICE, b"?") == b"?!"
    assert await server.call_service("/switch", SET_BOOL, b"self") == b"self!"


async def test_calls_run_side_by_side(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    waiting: list[asyncio.Event] = []

    async def meet(request: bytes) -> bytes:
        waiting.append(asyncio.Event())
        if len(waiting) == 3:
            for event in waiting:
                event.set()
        await waiting[-1].wait()
        return request

    await server.advertise_service("/meet", SET_BOOL, meet)
    calls = [client.call_service("/meet", SET_BOOL, bytes([n]), timeout_s=10.0) for n in range(3)]
    assert await asyncio.gather(*calls) == [b"\0", b"\1", b"\2"]


async def test_a_service_nobody_offers_is_unavailable(join: JoinGraph) -> None:
    client = await join("/client")
    with pytest.raises(ServiceUnavailableError, match="nobody offers the service /switch"):
        await client.call_service("/switch", SET_BOOL, b"")


async def test_a_service_that_was_closed_is_unavailable(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    handle = await server.advertise_service("/switch", SET_BOOL, echo)
    await handle.close()
    await handle.close()
    with pytest.raises(ServiceUnavailableError):
        await client.call_service("/switch", SET_BOOL, b"")
    await server.advertise_service("/switch", SET_BOOL, echo)
    assert await client.call_service("/switch", SET_BOOL, b"") == b"!"


async def test_a_call_has_a_time_limit(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    go_on = asyncio.Event()
    finished = []

    async def slow(request: bytes) -> bytes:
        await go_on.wait()
        finished.append(request)
        return request

    await server.advertise_service("/slow", SET_BOOL, slow)
    with pytest.raises(ServiceTimeoutError, match=r"/slow did not answer within 0.05 s"):
        await client.call_service("/slow", SET_BOOL, b"first", timeout_s=0.05)
    # The handler is not torn down half way, and the next call gets its own answer.
    go_on.set()
    await until(lambda: finished == [b"first"])
    assert await client.call_service("/slow", SET_BOOL, b"second", timeout_s=10.0) == b"second"


async def test_a_handlers_error_reaches_the_caller(join: JoinGraph, caplog: pytest.LogCaptureFixture) -> None:
    server, client = await join("/server"), await join("/client")

    async def refuse(_: bytes) -> bytes:
        raise SessionError("the board did not answer")

    async def fail(_: bytes) -> bytes:
        raise ZeroDivisionError("a user's mistake")

    await server.advertise_service("/refuse", SET_BOOL, refuse)
    await server.advertise_service("/fail", SET_BOOL, fail)
    with pytest.raises(ServiceCallError, match="the board did not answer"):
        await client.call_service("/refuse", SET_BOOL, b"")
    assert caplog.text == ""
    for _ in range(2):
        with pytest.raises(ServiceCallError, match="a user's mistake"):
            await client.call_service("/fail", SET_BOOL, b"")
    assert "handler of service /fail failed: ZeroDivisionError" in caplog.text


async def test_types_that_differ_are_named(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    await server.advertise_service("/switch", SET_BOOL, echo)
    with pytest.raises(TypeMismatchError, match=SET_BOOL.md5sum):
        await client.call_service("/switch", EMPTY, b"")


async def test_a_node_offers_a_service_once(join: JoinGraph) -> None:
    server = await join("/server")
    await server.advertise_service("/switch", SET_BOOL, echo)
    with pytest.raises(GraphError, match="offers the service /switch already"):
        await server.advertise_service("/switch", SET_BOOL, echo)


async def test_who_offers_a_service_last_has_it(join: JoinGraph) -> None:
    first, second, client = await join("/first"), await join("/second"), await join("/client")

    async def other(_: bytes) -> bytes:
        return b"second"

    old = await first.advertise_service("/switch", SET_BOOL, echo)
    await second.advertise_service("/switch", SET_BOOL, other)
    assert await client.call_service("/switch", SET_BOOL, b"") == b"second"
    await old.close()
    assert await client.call_service("/switch", SET_BOOL, b"") == b"second"


async def test_a_server_that_leaves_ends_the_calls_on_it(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    called = asyncio.Event()

    async def hang(_: bytes) -> bytes:
        called.set()
        await asyncio.Event().wait()
        raise AssertionError("unreachable")

    await server.advertise_service("/hang", SET_BOOL, hang)
    call = asyncio.ensure_future(client.call_service("/hang", SET_BOOL, b"", timeout_s=30.0))
    await called.wait()
    await server.close()
    with pytest.raises(ServiceCallError):
        await call
