"""A node and its master: joining, replacement, a restarted master, and leaving."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import SET_BOOL, STRING, Inbox
from rostether.errors import GraphError, InvalidNameError, MasterUnreachableError
from rostether.graph.ports import ParamValue
from rostether.graph.ros_clock import wall_time
from rostether.ros1.environment import RosEnvironment, parse_rpc_uri
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node import endpoint_handles as endpoints
from rostether.ros1.node import own_registrations
from rostether.ros1.node.clock import Clock
from rostether.ros1.node.node import Ros1Graph, join_ros1
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.ros1.xmlrpc_server import XmlRpcServer
from rostether.rostime import Time
from waiting import until

LOOPBACK = RosEnvironment.read({})
CHECK_INTERVAL_S = 0.02


class Stage:
    """A master that can be stopped and started again at the same place, and nodes that leave at the end."""

    def __init__(self) -> None:
        self.nodes: list[Ros1Graph] = []
        self.uri = ""

    async def start_master(self) -> None:
        port = parse_rpc_uri(self.uri).port if self.uri else 0
        self.master = await MasterServer.start(port=port)
        self.uri = self.master.uri

    async def join(self, name: str) -> Ros1Graph:
        node = await join_ros1(
            name, environment=LOOPBACK.with_master(self.uri), check_interval_s=CHECK_INTERVAL_S
        )
        self.nodes.append(node)
        return node


@pytest_asyncio.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    await stage.start_master()
    yield stage
    for node in stage.nodes:
        await node.close()
    await stage.master.close()


def descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


async def echo(request: bytes) -> bytes:
    return request


async def test_no_graph_to_join() -> None:
    with pytest.raises(MasterUnreachableError, match=r"127\.0\.0\.1:1/"):
        await join_ros1("/node", environment=LOOPBACK.with_master("http://127.0.0.1:1/"))


@pytest.mark.parametrize("name", ["", "bad name", "1st", "a-b"])
async def test_an_illegal_node_name_is_refused(name: str) -> None:
    with pytest.raises(InvalidNameError):
        await join_ros1(name, environment=LOOPBACK.with_master("http://127.0.0.1:1/"))


async def test_the_environment_names_the_master(stage: Stage) -> None:
    node = await join_ros1("/node", environment=RosEnvironment.read({"ROS_MASTER_URI": stage.uri}))
    stage.nodes.append(node)
    assert node.master_uri == stage.uri
    assert node.node_uri.startswith("http://127.0.0.1:")


async def test_a_master_that_restarts_gets_everything_again(
    stage: Stage, caplog: pytest.LogCaptureFixture
) -> None:
    talker, listener, inbox = await stage.join("/talker"), await stage.join("/listener"), Inbox()
    publisher = await talker.advertise("/chat", STRING)
    subscriber = await listener.subscribe("/chat", STRING, inbox.store)
    await talker.advertise_service("/switch", SET_BOOL, echo)
    seen: list[ParamValue] = []
    await listener.set_param("/rate", 1)
    await listener.watch_param("/rate", seen.append)
    await until(lambda: publisher.subscriber_count == subscriber.publisher_count == 1)
    connection = subscriber.connections[0]

    await stage.master.close()
    await until(lambda: "until the master is back" in caplog.text)
    # Connections stay while the master is away.
    publisher.publish_raw([b"meanwhile"])
    await until(lambda: inbox.payloads == [b"meanwhile"])
    # What begins meanwhile is registered later.
    early = await listener.subscribe("/late", STRING, inbox.store)

    await stage.start_master()
    await until(lambda: caplog.text.count("registered again") == 2)
    late = await (await stage.join("/newcomer")).advertise("/late", STRING)
    await until(lambda: late.subscriber_count == early.publisher_count == 1)
    snapshot = await listener.snapshot()
    assert snapshot.topics["/chat"].publishers == ("/talker",)
    assert snapshot.topics["/chat"].subscribers == ("/listener",)
    assert snapshot.topics["/chat"].type == STRING.name
    assert await listener.call_service("/switch", SET_BOOL, b"on") == b"on"
    # The new master has no parameters, and reports new ones.
    await talker.set_param("/rate", 2)
    await until(lambda: seen == [1, None, 2])
    publisher.publish_raw([b"afterwards"])
    await until(lambda: inbox.payloads == [b"meanwhile", b"afterwards"])
    assert subscriber.connections[0] is connection
    # Reported once by each node, however often it checked.
    assert caplog.text.count("waiting for it") <= 2


async def test_what_is_advertised_while_the_master_is_away_is_registered_later(stage: Stage) -> None:
    node = await stage.join("/node")
    await stage.master.close()
    await node.advertise("/chat", STRING)
    await node.advertise_service("/switch", SET_BOOL, echo)
    await stage.start_master()
    other = await stage.join("/other")
    while True:
        snapshot = await other.snapshot()
        if "/chat" in snapshot.topics and "/switch" in snapshot.services:
            break
        await asyncio.sleep(0.01)


async def test_a_node_that_was_removed_by_mistake_registers_again(stage: Stage) -> None:
    node, other = await stage.join("/node"), await stage.join("/other")
    await node.advertise("/chat", STRING)
    client = XmlRpcClient(stage.uri)
    for topic in ("/chat", "/rosout"):
        await client.call_status("unregisterPublisher", "/node", topic, node.node_uri)
    await client.close()
    while "/chat" not in (await other.snapshot()).topics:
        await asyncio.sleep(0.01)


async def test_a_node_leaves_on_a_shutdown_request(stage: Stage, caplog: pytest.LogCaptureFixture) -> None:
    node = await stage.join("/node")
    client = XmlRpcClient(node.node_uri)
    assert await client.call_status("shutdown", "/rosnode", "user request") == (1, "shutdown", 0)
    await client.close()
    assert await asyncio.wait_for(node.wait_closed(), 60) == "/rosnode requested a shutdown: user request"
    assert "leaving the graph: /rosnode requested a shutdown: user request" in caplog.text
    with pytest.raises(GraphError, match="/node has left the graph"):
        await node.advertise("/chat", STRING)


async def test_a_node_whose_name_was_taken_unnoticed_leaves(stage: Stage) -> None:
    node = await stage.join("/node")
    client = XmlRpcClient(stage.uri)
    server = XmlRpcServer({})
    await server.start()
    # A server without the shutdown method: the master's call is the only notice the old node gets.
    node._endpoints._server._methods._methods.pop("shutdown")
    await client.call_status("registerPublisher", "/node", "/chat", STRING.name, server.uri)
    assert "has taken the name /node" in await asyncio.wait_for(node.wait_closed(), 60)
    code, _, uri = await client.call_status("lookupNode", "/test", "/node")
    assert (code, uri) == (1, server.uri)
    await client.close()
    await server.close()


async def test_simulated_time_is_zero_until_the_clock_ticks(stage: Stage) -> None:
    ticker = await stage.join("/ticker")
    await ticker.set_param("/use_sim_time", True)
    node = await stage.join("/node")
    assert node.now() == (0, 0)
    clock = await ticker.advertise("/clock", STRING.__class__("*", "*"))
    await until(lambda: clock.subscriber_count == 1)
    clock.publish_raw([b"short", (5).to_bytes(4, "little") + (7).to_bytes(4, "little")])
    await until(lambda: node.now() == (5, 7))
    clock.publish_raw([b"short"])
    assert ticker.now() > node.now()


async def test_leaving_is_quick_when_the_master_hangs(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (endpoints, own_registrations):
        monkeypatch.setattr(module, "UNREGISTER_TIMEOUT_S", 0.05)
    node = await stage.join("/node")
    await node.advertise("/chat", STRING)
    await node.watch_param("/rate", lambda _: None)
    await stage.master.close()

    async def hang(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()

    silent = await asyncio.start_server(hang, "127.0.0.1", parse_rpc_uri(stage.uri).port)
    await asyncio.wait_for(node.close(), 60.0)
    silent.close()
    await silent.wait_closed()


@pytest.mark.slow
async def test_leaving_ends_all_tasks_and_connections(stage: Stage) -> None:
    witness = await stage.join("/witness")
    await witness.advertise("/back", STRING)

    async def cycle() -> None:
        node = await stage.join("/node")
        stage.nodes.remove(node)
        publisher = await node.advertise("/chat", STRING, latch=True)
        await node.subscribe("/chat", STRING, lambda _: None)
        subscriber = await node.subscribe("/back", STRING, lambda _: None)
        await node.advertise_service("/switch", SET_BOOL, echo)
        await node.watch_param("/rate", lambda _: None)
        await node.call_service("/switch", SET_BOOL, b"on")
        await until(lambda: publisher.subscriber_count == subscriber.publisher_count == 1)
        await node.close()

    await cycle()
    await until(lambda: len(asyncio.all_tasks()) <= 10)
    tasks, opened = len(asyncio.all_tasks()), descriptors()
    for _ in range(60):
        await cycle()
    await until(lambda: len(asyncio.all_tasks()) <= tasks)
    await until(lambda: descriptors() <= opened + 4)
    assert (await witness.snapshot()).nodes == ("/witness",)


async def test_a_failed_join_leaves_no_tasks_and_descriptors() -> None:
    before = descriptors()
    for _ in range(20):
        with pytest.raises(MasterUnreachableError):
            await join_ros1("/node", environment=LOOPBACK.with_master("http://127.0.0.1:1/"))
    await until(lambda: len(asyncio.all_tasks()) == 1)
    await until(lambda: descriptors() <= before + 1)


def test_the_wall_clock_unless_simulated() -> None:
    clock = Clock()
    assert wall_time() <= clock.now() <= wall_time()
    clock.simulate()
    assert clock.now() == Time(0, 0)
    clock.handle_messages([struct.pack("<II", 1, 2), struct.pack("<II", 3, 4)])
    assert clock.now() == Time(3, 4)


def test_a_malformed_tick_is_ignored() -> None:
    clock = Clock()
    clock.simulate()
    clock.handle_messages([struct.pack("<II", 3, 4)])
    clock.handle_messages([b""])
    clock.handle_messages([bytes(9)])
    assert clock.now() == Time(3, 4)
