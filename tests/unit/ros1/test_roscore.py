"""The master with its log collector."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError, GraphError
from rostether.graph.log_message import LOG_TYPE
from rostether.graph.ports import Level
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.node import Ros1Graph, join_ros1
from rostether.ros1.roscore import Roscore
from rostether.ros1.xmlrpc_client import XmlRpcClient
from waiting import until


@pytest.fixture
async def core(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Roscore]:
    monkeypatch.setattr("rostether.ros1.roscore._RESPAWN_PAUSE_S", 0.02)
    core = await Roscore.start(RosEnvironment(), port=0)
    yield core
    await core.close()
    await core.close()


@pytest.fixture
async def node(core: Roscore) -> AsyncIterator[Ros1Graph]:
    node = await join_ros1("tester", environment=RosEnvironment().with_master(core.uri))
    yield node
    await node.close()


async def logs_arrive(node: Ros1Graph) -> None:
    """Log until it arrives: the first messages may come before the connections."""
    logs: list[bytes] = []
    collected = await node.subscribe("/rosout_agg", LOG_TYPE, logs.extend)
    async with asyncio.timeout(60):
        while not any(b"battery low" in log and b"/tester" in log for log in logs):
            node.log(Level.WARN, "battery low")
            await asyncio.sleep(0.01)
    await collected.close()


async def test_every_node_s_logs_arrive_on_rosout_agg(node: Ros1Graph) -> None:
    await logs_arrive(node)


async def test_the_graph_looks_as_roscore_s(node: Ros1Graph) -> None:
    snapshot = await node.snapshot()
    assert "/rosout" in snapshot.nodes
    assert snapshot.topics["/rosout_agg"].publishers == ("/rosout",)
    assert "/rosout" in snapshot.topics["/rosout"].subscribers


async def test_rosout_starts_again_when_it_is_killed(core: Roscore, node: Ros1Graph) -> None:
    first = core._rosout
    assert first is not None
    killer = XmlRpcClient(first.node_uri)
    await killer.call("shutdown", "/rosnode", "user request")
    await killer.close()
    await until(lambda: core._rosout not in (None, first))
    await logs_arrive(node)


async def test_a_host_name_without_an_address_is_reported(
    core: Roscore, caplog: pytest.LogCaptureFixture
) -> None:
    unknown = replace(RosEnvironment(), advertised_host="no-such-host.invalid")
    with pytest.raises(ConfigError, match=r"does not know the host name no-such-host\.invalid"):
        await Roscore.start(unknown, port=0)
    assert not caplog.messages
    node = await join_ros1("stranger", environment=unknown.with_master(core.uri))
    await until(lambda: any("other nodes cannot connect" in message for message in caplog.messages))
    await node.close()


async def test_a_busy_port_is_reported(core: Roscore) -> None:
    port = int(core.uri.rpartition(":")[2].strip("/"))
    with pytest.raises(GraphError, match=f"port {port}"):
        await Roscore.start(RosEnvironment(), port=port)


async def test_a_master_stopped_from_outside_can_be_waited_for(core: Roscore) -> None:
    client = XmlRpcClient(core.uri)
    await client.call("shutdown", "/x", "enough")
    await client.close()
    await asyncio.wait_for(core.wait_closed(), 60)
