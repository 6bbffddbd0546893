"""The XML-RPC server, over real sockets of loopback."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any

import pytest

from rostether.errors import ConfigError, GraphError, UnknownNameError
from rostether.ros1.graph_limits import GraphLimits
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from unit.ros1.xmlrpc_stage import RawClient, client_of, later, request, serving


async def test_plain_and_async_methods_answer() -> None:
    async with serving({"add": lambda a, b: a + b, "later": later}) as server, client_of(server) as client:
        assert await client.call("add", 1, 2) == 3
        assert await client.call("later", {"a": [1.5]}) == {"a": [1.5]}


async def test_overlapping_calls_do_not_wait_for_each_other() -> None:
    first_began, finish_first = asyncio.Event(), asyncio.Event()

    async def first() -> int:
        first_began.set()
        await finish_first.wait()
        return 1

    async with serving({"first": first, "second": lambda: 2}) as server, client_of(server) as client:
        task = asyncio.create_task(client.call("first"))
        await first_began.wait()
        assert await client.call("second") == 2
        assert not task.done()
        finish_first.set()
        assert await task == 1


async def test_an_unknown_method_is_a_fault() -> None:
    async with serving({}) as server, client_of(server) as client:
        with pytest.raises(GraphError, match='refused nope: method "nope" is not supported'):
            await client.call("nope")


async def test_wrong_arguments_are_a_fault() -> None:
    async with serving({"one": lambda a: a}) as server, client_of(server) as client:
        with pytest.raises(GraphError, match="one: bad arguments"):
            await client.call("one", 1, 2)


async def test_our_errors_become_status_triplets() -> None:
    def missing() -> None:
        raise UnknownNameError("no such topic")

    async def missing_later() -> None:
        raise UnknownNameError("no such topic")

    async with (
        serving({"missing": missing, "later": missing_later}) as server,
        client_of(server) as client,
    ):
        assert await client.call_status("missing") == (-1, "no such topic", 0)
        assert await client.call_status("later") == (-1, "no such topic", 0)


async def test_a_bug_in_a_method_is_a_fault_and_logged(caplog: pytest.LogCaptureFixture) -> None:
    def broken() -> None:
        raise ZeroDivisionError("by zero")

    async def broken_later() -> None:
        raise ZeroDivisionError("by zero")

    async with serving({"broken": broken, "later": broken_later}) as server, client_of(server) as client:
        with caplog.at_level(logging.ERROR, "rostether"):
            for method in ("broken", "later"):
                with pytest.raises(GraphError, match=f"{method} failed: ZeroDivisionError: by zero"):
                    await client.call(method)
        assert len(caplog.records) == 2


async def test_a_value_that_cannot_be_sent_is_a_fault() -> None:
    async with serving({"big": lambda: 2**40}) as server, client_of(server) as client:
        with pytest.raises(GraphError, match="does not fit in the 32 bits"):
            await client.call("big")


async def test_multicall() -> None:
    methods: dict[str, Callable[..., Any]] = {
        "add": lambda a, b: a + b,
        "later": later,
        "broken": lambda: 1 / 0,
    }
    async with serving(methods) as server, client_of(server) as client:
        calls = [
            {"methodName": "add", "params": [1, 2]},
            {"methodName": "later", "params": ["x"]},
            {"methodName": "nope"},
            {"methodName": "broken", "params": []},
            {"methodName": "system.multicall", "params": [[]]},
            {"methodName": 5, "params": []},
            "nonsense",
        ]
        answers = await client.call("system.multicall", calls)
        assert isinstance(answers, list)
        assert answers[:2] == [[3], ["x"]]
        texts = [answer["faultString"] for answer in answers[2:] if isinstance(answer, dict)]
        assert len(texts) == 5
        assert 'method "nope" is not supported' in str(texts[0])
        with pytest.raises(GraphError, match="needs an array"):
            await client.call("system.multicall", "x")


async def test_methods_are_listed() -> None:
    async with serving({"b": int, "a": int}) as server, client_of(server) as client:
        assert await client.call("system.listMethods") == ["a", "b", "system.listMethods", "system.multicall"]


async def test_the_longest_idle_connection_makes_room() -> None:
    async with serving({"ping": lambda: 1}, limits=GraphLimits(xmlrpc_connections=2)) as server:
        first = await RawClient.connect(server)
        second = await RawClient.connect(server)
        for raw in (first, second, first):
            raw.writer.write(request("ping"))
            assert await raw.answer() == 1
        third = await RawClient.connect(server)
        third.writer.write(request("ping"))
        assert await third.answer() == 1
        assert await second.reader.read() == b"", "idle the longest"
        first.writer.write(request("ping"))
        assert await first.answer() == 1
        for raw in (first, second, third):
            await raw.close()


async def test_incomplete_requests_replace_each_other_and_no_active_client() -> None:
    async with serving({"ping": lambda: 1}, limits=GraphLimits(xmlrpc_connections=4)) as server:
        resting = await RawClient.connect(server)
        resting.writer.write(request("ping"))
        assert await resting.answer() == 1
        half_open = [await RawClient.connect(server) for _ in range(12)]
        for raw in half_open[-2:]:
            # A part of a request does not protect a connection from being replaced.
            raw.writer.write(request("ping")[:-1])
        newcomer = await RawClient.connect(server)
        for raw in (newcomer, resting):
            raw.writer.write(request("ping"))
            assert await raw.answer() == 1
        assert await half_open[0].reader.read() == b""
        for raw in (resting, newcomer, *half_open):
            await raw.close()


async def test_a_busy_port_is_named() -> None:
    async with serving({}) as server:
        second = XmlRpcServer({}, port=server.port)
        with pytest.raises(GraphError, match=f"port {server.port} of 127.0.0.1 .*choose another port"):
            await second.start()
        await second.close()


async def test_an_address_of_another_machine_is_reported() -> None:
    server = XmlRpcServer({}, hosts=["192.0.2.1"])
    with pytest.raises(ConfigError, match=r"192\.0\.2\.1: not an address of this machine; check ROS_IP"):
        await server.start()


async def test_all_addresses_share_one_port() -> None:
    async with serving({"ping": lambda: 1}, hosts=["127.0.0.2", "127.0.0.1"]) as server:
        for host in ("127.0.0.1", "127.0.0.2"):
            client = XmlRpcClient(f"http://{host}:{server.port}")
            assert await client.call("ping") == 1
            await client.close()


async def test_the_uri_has_the_advertised_host() -> None:
    async with serving({}, advertised_host="robot.local") as server:
        assert server.uri == f"http://robot.local:{server.port}/"
        assert server.port > 0


async def test_close_ends_connections_and_frees_the_port() -> None:
    server = XmlRpcServer({"ping": lambda: 1})
    await server.start()
    raw = await RawClient.connect(server)
    raw.writer.write(request("ping"))
    await raw.answer()
    await server.close()
    await server.close()
    assert await raw.reader.read() == b""
    await raw.close()
    again = XmlRpcServer({}, port=server.port)
    await again.start()
    await again.close()


async def test_close_does_not_wait_for_a_client_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.ros1.xmlrpc_server._CLOSE_GRACE_S", 0.05)
    server = XmlRpcServer({"big": lambda: "x" * 8_000_000})
    await server.start()
    raw = await RawClient.connect(server)
    raw.reader._transport.pause_reading()  # type: ignore[attr-defined]
    raw.writer.write(request("big"))
    await asyncio.sleep(0.05)
    async with asyncio.timeout(60):
        await server.close()
    raw.writer.transport.abort()
    await raw.close()
