"""A whole master over loopback."""

from __future__ import annotations

import asyncio
import logging
import re
from collections.abc import AsyncIterator
from typing import TypeVar

import pytest

from rostether.errors import GraphError
from rostether.ros1.master import server as module
from rostether.ros1.master.server import MasterServer
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from waiting import until

T = TypeVar("T")


def note(notes: list[T], item: T) -> list[object]:
    notes.append(item)
    return [1, "", 0]


@pytest.fixture
async def master() -> AsyncIterator[MasterServer]:
    master = await MasterServer.start(port=0)
    yield master
    await master.close()


@pytest.fixture
async def client(master: MasterServer) -> AsyncIterator[XmlRpcClient]:
    client = XmlRpcClient(master.uri)
    yield client
    await client.close()


async def test_it_has_what_roscore_sets(client: XmlRpcClient, master: MasterServer) -> None:
    run_id = (await client.call_status("getParam", "/x", "/run_id"))[2]
    assert re.fullmatch(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", str(run_id))
    assert (await client.call_status("getParam", "/x", "/rosdistro"))[2] == "noetic\n"
    assert (await client.call_status("getParam", "/x", "/rosversion"))[2] == "1.16.0\n"
    assert (await client.call_status("getUri", "/x"))[2] == master.uri


async def test_subscribers_are_informed_about_publishers(client: XmlRpcClient) -> None:
    received: list[list[str]] = []
    node = XmlRpcServer(
        {
            "getPid": lambda _caller: [1, "", 1],
            "publisherUpdate": lambda _caller, _topic, uris: note(received, uris),
        }
    )
    await node.start()
    await client.call("registerSubscriber", "/s", "/t", "*", node.uri)
    await client.call("registerPublisher", "/s", "/t", "std_msgs/String", node.uri)
    await until(lambda: received)
    assert received == [[node.uri]]
    await node.close()


async def test_a_node_that_dies_is_dropped_and_logged(
    client: XmlRpcClient, master: MasterServer, caplog: pytest.LogCaptureFixture
) -> None:
    node = XmlRpcServer({"getPid": lambda _caller: [1, "", 1]})
    await node.start()
    await client.call("registerPublisher", "/p", "/t", "std_msgs/String", node.uri)
    await until(lambda: node._connections)
    with caplog.at_level(logging.WARNING, "rostether"):
        await node.close()
        await until(lambda: not master.api.registrations.nodes)
    assert f"removed the registrations of /p at {node.uri}" in caplog.text
    assert (await client.call_status("getSystemState", "/x"))[2] == [[], [], []]


async def test_nodes_are_pinged(
    client: XmlRpcClient, master: MasterServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    pings: list[str] = []
    node = XmlRpcServer({"getPid": lambda caller: note(pings, caller)})
    await node.start()
    monkeypatch.setattr(module, "PING_INTERVAL_S", 0.02)
    master._ping_all()
    await client.call("registerPublisher", "/p", "/t", "std_msgs/String", node.uri)
    await until(lambda: len(pings) >= 3)
    await client.call("unregisterPublisher", "/p", "/t", node.uri)
    await until(lambda: not node._connections)
    await node.close()


async def test_it_stops_when_asked_to(client: XmlRpcClient, master: MasterServer) -> None:
    assert await client.call("shutdown", "/x", "enough") == [1, "shutdown", 0]
    await asyncio.wait_for(master.wait_closed(), 60)
    with pytest.raises(GraphError):
        await client.call("getPid", "/x")


async def test_a_second_master_on_the_port_is_refused(master: MasterServer) -> None:
    port = int(master.uri.rpartition(":")[2].strip("/"))
    with pytest.raises(GraphError, match=f"port {port}"):
        await MasterServer.start(port=port)


async def test_several_addresses_and_an_advertised_name() -> None:
    master = await MasterServer.start(("127.0.0.2", "127.0.0.1"), 0, advertised_host="localhost")
    client = XmlRpcClient(master.uri)
    assert (await client.call_status("getUri", "/x"))[2] == master.uri
    assert master.uri.startswith("http://localhost:")
    await client.close()
    await master.close()


def test_run_ids_differ() -> None:
    assert len({module._new_run_id() for _ in range(10)}) == 10
