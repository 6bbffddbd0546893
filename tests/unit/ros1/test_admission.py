"""--allow at every server of a graph: other networks are disconnected before any of their bytes is read."""

from __future__ import annotations

import asyncio
import logging

import pytest

from rostether.errors import ConfigError
from rostether.ros1.admission import Admission
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import join_ros1
from rostether.ros1.node.tcpros_listener import TcprosListener
from rostether.ros1.roscore import Roscore
from unit.ros1.xmlrpc_stage import client_of, request, serving
from unit.transports.strangers import is_hung_up, stranger, trust_nobody


def never(*_: object) -> asyncio.Protocol:
    raise AssertionError


@pytest.fixture(autouse=True)
def nobody_is_trusted(monkeypatch: pytest.MonkeyPatch) -> None:
    trust_nobody(monkeypatch)


async def test_the_xmlrpc_server_disconnects_other_networks_and_answers_this_machine() -> None:
    called: list[str] = []

    def note(text: str) -> int:
        called.append(text)
        return 1

    admission = Admission(["10.0.0.0/8"])
    async with serving({"note": note}, admission=admission) as server:
        async with stranger(server.port) as (reader, writer):
            writer.write(request("note", "stranger"))
            assert await is_hung_up(reader)
        async with client_of(server) as client:
            assert await client.call("note", "friend") == 1
        assert not [each for each in server._connections if each.host == "127.0.0.2"]
    assert (called, admission.refusals.count) == (["friend"], 1)


async def test_xmlrpc_server_answers_the_networks_allowed() -> None:
    async with (
        serving({"ping": lambda: 1}, admission=Admission(["127.0.0.2/32"])) as server,
        stranger(server.port) as (reader, writer),
    ):
        writer.write(request("ping"))
        assert (await reader.read(100)).startswith(b"HTTP/1.1 200")


async def test_the_tcpros_listener_disconnects_other_networks() -> None:
    admission = Admission(["10.0.0.0/8"])
    listener = TcprosListener(never, never, lambda *_: None, admission)
    await listener.start(["127.0.0.1"])
    try:
        async with stranger(listener.port) as (reader, writer):
            writer.write(b"\x05\0\0\0\x09\0\0\0x")
            assert await is_hung_up(reader)
        assert not listener._handshakes
        assert admission.refusals.count == 1
    finally:
        await listener.close()


async def test_a_scan_of_all_servers_is_one_line(caplog: pytest.LogCaptureFixture) -> None:
    environment = RosEnvironment().allowing(["10.0.0.0/8"])
    core = await Roscore.start(environment, port=0)
    try:
        graph = await join_ros1("node", environment=environment.with_master(core.uri))
        try:
            for uri in (core.uri, graph.node_uri):
                async with stranger(int(uri.rstrip("/").rpartition(":")[2])) as (reader, _):
                    assert await is_hung_up(reader)
            async with stranger(graph._endpoints.tcpros_address[1]) as (reader, _):
                assert await is_hung_up(reader)
        finally:
            await graph.close()
    finally:
        await core.close()
    assert environment.admission.refusals.count == 3
    lines = [each.getMessage() for each in caplog.records if each.levelno >= logging.WARNING]
    assert lines == ["the ROS graph's servers refused 127.0.0.2: its address is not in --allow"]


def test_no_network_is_reported() -> None:
    with pytest.raises(ConfigError, match=r"--allow: '10\.0\.0\.0/99' is not a network"):
        RosEnvironment().allowing(["10.0.0.0/99"])
    assert RosEnvironment().allowing(()) == RosEnvironment()
