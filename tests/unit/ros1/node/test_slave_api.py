"""The Slave API, as the master and rosnode call it."""

from __future__ import annotations

import os
import re
from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio

from contract.graphs import STRING, Inbox
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.master.server import MasterServer
from rostether.ros1.node.node import Ros1Graph, join_ros1
from rostether.ros1.xmlrpc_client import XmlRpcClient
from waiting import until

# As rosnode takes it apart to show connections.
ROSNODE_PATTERN = re.compile(r"\w+ connection on port (\d+) to \[(.*) on socket (\d+)\]")


class Stage:
    def __init__(self, node: Ros1Graph) -> None:
        self.node = node
        self.client = XmlRpcClient(node.node_uri)

    async def ask(self, method: str, *args: object) -> Any:
        code, _, value = await self.client.call_status(method, "/test", *args)
        assert code == 1
        return value

    async def fail(self, method: str, *args: object) -> tuple[int, str]:
        code, text, _ = await self.client.call_status(method, "/test", *args)
        return code, text


@pytest_asyncio.fixture
async def stage() -> AsyncIterator[Stage]:
    master = await MasterServer.start(port=0)
    node = await join_ros1("/node", environment=RosEnvironment.read({}).with_master(master.uri))
    stage = Stage(node)
    yield stage
    await stage.client.close()
    await node.close()
    await master.close()


async def test_identity_of_a_node(stage: Stage) -> None:
    assert await stage.ask("getPid") == os.getpid()
    assert await stage.ask("getName") == "/node"
    assert await stage.ask("getUri") == stage.node.node_uri
    assert await stage.ask("getMasterUri") == stage.node.master_uri


async def test_what_it_publishes_and_subscribes_to(stage: Stage) -> None:
    await stage.node.advertise("/chat", STRING)
    await stage.node.subscribe("/in", STRING, lambda _: None)
    await stage.node.subscribe("/in", STRING, lambda _: None)
    assert await stage.ask("getPublications") == [
        ["/rosout", "rosgraph_msgs/Log"],
        ["/chat", "std_msgs/String"],
    ]
    assert await stage.ask("getSubscriptions") == [["/in", "std_msgs/String"]]


async def test_its_connections(stage: Stage) -> None:
    inbox = Inbox()
    publisher = await stage.node.advertise("/chat", STRING)
    await stage.node.subscribe("/chat", STRING, inbox.store)
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([b"one", b"four"])
    await until(lambda: len(inbox.payloads) == 2)
    out, into = await stage.ask("getBusInfo")
    # Connection id, the other side, direction, transport, topic, connected, description.
    assert out[1:6] == ["/node", "o", "TCPROS", "/chat", True]
    assert into[1:6] == [stage.node.node_uri, "i", "TCPROS", "/chat", True]
    for entry in (out, into):
        match = ROSNODE_PATTERN.fullmatch(entry[6])
        assert match is not None
        port, peer, number = match.groups()
        assert int(port) > 0
        assert peer.startswith("127.0.0.1:")
        assert int(number) > 2
    published, subscribed, services = await stage.ask("getBusStats")
    out_id, in_id = out[0], into[0]
    assert ["/chat", 15, [[out_id, 15, 2, True]]] in published
    assert subscribed == [["/chat", [[in_id, 15, 2, -1, True]]]]
    assert services == []


async def test_where_to_connect_for_a_topic(stage: Stage) -> None:
    await stage.node.advertise("/chat", STRING)
    protocol = await stage.ask("requestTopic", "/chat", [["UDPROS", "x", "h", 1, 1500], ["TCPROS"]])
    assert isinstance(protocol, list)
    assert protocol[:2] == ["TCPROS", "127.0.0.1"]
    assert isinstance(protocol[2], int)


@pytest.mark.parametrize(
    ("args", "code"),
    [
        (("/chat", [["UDPROS", "x", "h", 1, 1500]]), 0),
        (("/chat", []), 0),
        (("/nothing", [["TCPROS"]]), -1),
        (("/chat", "TCPROS"), -1),
        (("/chat", [[]]), -1),
        (("/chat", [1]), -1),
    ],
)
async def test_requests_that_cannot_be_met_are_answered(stage: Stage, args: tuple[object], code: int) -> None:
    await stage.node.advertise("/chat", STRING)
    assert (await stage.fail("requestTopic", *args))[0] == code


async def test_unrequested_updates_are_answered(stage: Stage) -> None:
    assert await stage.fail("paramUpdate", "/rate", 1) == (-1, "not subscribed")
    assert (await stage.fail("paramUpdate", 1, 1))[0] == -1
    assert (await stage.fail("publisherUpdate", "/chat", "http://x:1/"))[0] == -1
    assert await stage.ask("publisherUpdate", "/nothing", ["http://127.0.0.1:1/", 5]) == 0


async def test_calls_without_arguments_do_not_stop_the_node(stage: Stage) -> None:
    with pytest.raises(Exception, match="bad arguments"):
        await stage.client.call("getPid")
    assert await stage.ask("getPid") == os.getpid()
