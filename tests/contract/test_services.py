"""Offering and calling services."""

from __future__ import annotations

import asyncio
from typing import cast

import pytest

from contract.capabilities import Capabilities
from contract.graphs import (
    ADD_DIAGNOSTICS,
    EMPTY,
    FALSE,
    SET_BOOL,
    TRUE,
    answer,
    answer_set_bool,
    string,
    wait_for_service,
    wait_for_snapshot,
)
from rostether.errors import (
    GraphError,
    ServiceCallError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    SessionError,
    TypeMismatchError,
)
from rostether.graph.ports import JoinGraph, ListsClients
from rostether.msgdef.interface import ANY_MESSAGE, ServiceType
from rostether.ros2.endpoint_info import EndpointKind, Ros2Graph
from waiting import until

ANY_SERVICE = ServiceType("*", "*", ANY_MESSAGE, ANY_MESSAGE)


async def test_a_call_is_answered(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    handle = await server.advertise_service("/switch", SET_BOOL, answer_set_bool)
    assert handle.service == "/switch"
    await wait_for_service(client, "/switch")
    for request in (TRUE, FALSE):
        expected = answer("done", success=request == TRUE)
        assert await client.call_service("/switch", SET_BOOL, request, timeout_s=60) == expected
    assert await client.call_service("switch", SET_BOOL, TRUE) == answer("done")
    assert await server.call_service("/switch", SET_BOOL, TRUE) == answer("done")


async def test_empty_and_large_payloads_are_carried(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")

    async def echo(request: bytes) -> bytes:
        return TRUE + request

    async def answer_empty(request: bytes) -> bytes:
        assert request == b""
        return b""

    await server.advertise_service("/echo", ADD_DIAGNOSTICS, echo)
    await server.advertise_service("/empty", EMPTY, answer_empty)
    await wait_for_service(client, "/empty")
    await wait_for_service(client, "/echo")
    for text in ("", "ä", "x" * (1 << 20)):
        received = await client.call_service("/echo", ADD_DIAGNOSTICS, string(text), timeout_s=60)
        assert received == answer(text)
    assert await client.call_service("/empty", EMPTY, b"", timeout_s=60) == b""


async def test_a_call_needs_no_type(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    await server.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await wait_for_service(client, "/switch")
    assert await client.call_service("switch", ANY_SERVICE, TRUE) == answer("done")


async def test_calls_run_side_by_side(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    waiting: list[asyncio.Event] = []

    async def wait_for_three(request: bytes) -> bytes:
        waiting.append(asyncio.Event())
        if len(waiting) == 3:
            for event in waiting:
                event.set()
        await waiting[-1].wait()
        return TRUE + request

    await server.advertise_service("/wait", ADD_DIAGNOSTICS, wait_for_three)
    await wait_for_service(client, "/wait")
    calls = [client.call_service("/wait", ADD_DIAGNOSTICS, string(text), timeout_s=60) for text in "abc"]
    assert await asyncio.gather(*calls) == [answer("a"), answer("b"), answer("c")]


async def test_a_service_without_a_server_is_unavailable(join: JoinGraph) -> None:
    client = await join("/client")
    with pytest.raises(ServiceUnavailableError, match="no node offers the service /switch"):
        await client.call_service("/switch", SET_BOOL, TRUE)


async def test_a_service_that_was_closed_is_unavailable(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    handle = await server.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await wait_for_service(client, "/switch")
    await handle.close()
    await handle.close()
    await wait_for_snapshot(client, lambda snapshot: "/switch" not in snapshot.services)
    with pytest.raises(ServiceUnavailableError):
        await client.call_service("/switch", SET_BOOL, TRUE)
    await server.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await wait_for_service(client, "/switch")
    assert await client.call_service("/switch", SET_BOOL, TRUE) == answer("done")


async def test_a_call_has_a_time_limit(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    may_answer = asyncio.Event()
    finished = []

    async def slow(request: bytes) -> bytes:
        await may_answer.wait()
        finished.append(request)
        return TRUE + request

    await server.advertise_service("/slow", ADD_DIAGNOSTICS, slow)
    await wait_for_service(client, "/slow")
    with pytest.raises(ServiceTimeoutError, match="/slow did not answer within 1 s"):
        await client.call_service("/slow", ADD_DIAGNOSTICS, string("first"), timeout_s=1.0)
    # The handler runs to its end, and the next call gets its own answer.
    may_answer.set()
    await until(lambda: finished == [string("first")])
    second = await client.call_service("/slow", ADD_DIAGNOSTICS, string("second"), timeout_s=60)
    assert second == answer("second")


async def test_a_handlers_error_reaches_the_caller(
    join: JoinGraph, capabilities: Capabilities, caplog: pytest.LogCaptureFixture
) -> None:
    capabilities.require("sends_service_errors")
    server, client = await join("/server"), await join("/client")

    async def refuse(_: bytes) -> bytes:
        raise SessionError("the board did not answer")

    async def fail(_: bytes) -> bytes:
        raise ZeroDivisionError("a user's mistake")

    await server.advertise_service("/refuse", SET_BOOL, refuse)
    await server.advertise_service("/fail", SET_BOOL, fail)
    await wait_for_service(client, "/refuse")
    await wait_for_service(client, "/fail")
    with pytest.raises(ServiceCallError, match="the board did not answer"):
        await client.call_service("/refuse", SET_BOOL, TRUE)
    assert "/refuse failed" not in caplog.text
    for _ in range(2):
        with pytest.raises(ServiceCallError, match="a user's mistake"):
            await client.call_service("/fail", SET_BOOL, TRUE)
    assert "handler of service /fail failed: ZeroDivisionError" in caplog.text


async def test_a_service_works_after_an_error_of_its_handler(
    join: JoinGraph, capabilities: Capabilities, caplog: pytest.LogCaptureFixture
) -> None:
    server, client = await join("/server"), await join("/client")

    async def fail_if_false(request: bytes) -> bytes:
        if request == FALSE:
            raise ZeroDivisionError("a user's mistake")
        return answer()

    await server.advertise_service("/sometimes", SET_BOOL, fail_if_false)
    await wait_for_service(client, "/sometimes")
    with pytest.raises(ServiceCallError):
        # Without an answer, the call ends at its time limit.
        timeout_s = 60.0 if capabilities.sends_service_errors else 1.0
        await client.call_service("/sometimes", SET_BOOL, FALSE, timeout_s=timeout_s)
    await until(lambda: "handler of service /sometimes failed: ZeroDivisionError" in caplog.text)
    assert await client.call_service("/sometimes", SET_BOOL, TRUE, timeout_s=60) == answer()


async def test_an_error_names_types_that_differ(join: JoinGraph, capabilities: Capabilities) -> None:
    server, client = await join("/server"), await join("/client")
    await server.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await wait_for_service(client, "/switch")
    with pytest.raises(TypeMismatchError) as caught:
        await client.call_service("/switch", EMPTY, b"")
    if capabilities.sends_definitions:
        assert SET_BOOL.md5sum in str(caught.value)
    else:
        assert "SetBool" in str(caught.value)
        assert "Empty" in str(caught.value)


async def test_a_node_offers_a_service_once(join: JoinGraph) -> None:
    server = await join("/server")
    await server.advertise_service("/switch", SET_BOOL, answer_set_bool)
    with pytest.raises(GraphError, match="offers the service /switch;"):
        await server.advertise_service("/switch", SET_BOOL, answer_set_bool)


async def test_the_last_server_of_a_service_is_called(join: JoinGraph, capabilities: Capabilities) -> None:
    capabilities.require("last_server_wins")
    first, second, client = await join("/first"), await join("/second"), await join("/client")

    async def other(_: bytes) -> bytes:
        return answer("second")

    old = await first.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await second.advertise_service("/switch", SET_BOOL, other)
    assert await client.call_service("/switch", SET_BOOL, TRUE) == answer("second")
    await old.close()
    assert await client.call_service("/switch", SET_BOOL, TRUE) == answer("second")


async def test_calls_fail_when_their_server_leaves(join: JoinGraph) -> None:
    server, client = await join("/server"), await join("/client")
    called = asyncio.Event()

    async def hang(_: bytes) -> bytes:
        called.set()
        await asyncio.Event().wait()
        raise AssertionError("unreachable")

    await server.advertise_service("/hang", SET_BOOL, hang)
    await wait_for_service(client, "/hang")
    call = asyncio.ensure_future(client.call_service("/hang", SET_BOOL, TRUE, timeout_s=60))
    await called.wait()
    await server.close()
    with pytest.raises(ServiceCallError):
        await asyncio.wait_for(call, 60)


async def test_a_client_is_listed_before_it_calls(join: JoinGraph, capabilities: Capabilities) -> None:
    capabilities.require("lists_clients")
    node, other = await join("/node"), await join("/other")

    async def wait_until_listed(expected: int) -> None:
        seen = -1
        async with asyncio.timeout(60):
            while seen != expected:
                endpoints = await cast(Ros2Graph, other).endpoints()
                clients = [each for each in endpoints if each.kind is EndpointKind.CLIENT]
                client = ("/node", "/switch", "std_srvs/srv/SetBool")
                seen = [(each.node_name, each.name, each.type) for each in clients].count(client)
                await asyncio.sleep(0.005)

    assert isinstance(node, ListsClients)
    first, second = await node.list_client("switch", SET_BOOL), await node.list_client("/switch", SET_BOOL)
    await wait_until_listed(1)
    await other.advertise_service("/switch", SET_BOOL, answer_set_bool)
    await wait_for_service(node, "/switch")
    await first.close()
    await first.close()
    assert await node.call_service("/switch", SET_BOOL, TRUE, timeout_s=60) == answer("done")
    await wait_until_listed(1)
    await second.close()
    await wait_until_listed(0)
    # A call registers the client again, and the handle may still exist when the node has left.
    assert await node.call_service("/switch", SET_BOOL, TRUE, timeout_s=60) == answer("done")
    late = await node.list_client("/switch", SET_BOOL)
    await wait_until_listed(1)
    await node.close()
    await late.close()
    await wait_until_listed(0)
