from __future__ import annotations

import json
from collections.abc import Mapping

import pytest
from websockets.asyncio.client import connect

from rostether.cli.gateway.gateways import GatewayGraph, joined_as
from rostether.cli.gateway.node import NodeNaming
from rostether.cli.gateway.options import GatewayOptions
from rostether.cli.gateway.rosbridge import rosbridge_gateway
from rostether.errors import GraphError, MasterUnreachableError, UnknownTypeError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore


class Refusing:
    """Joins in memory, except the node /rosapi; first raises the given errors."""

    def __init__(self, *faults: Exception, name: str = "/rosapi") -> None:
        self.network = MemoryNetwork()
        self._faults = list(faults)
        self._name = name

    async def __call__(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> MemoryGraph:
        if node_name == self._name and self._faults:
            raise self._faults.pop(0)
        return await self.network.join(node_name, namespace=namespace, remappings=remappings)


@pytest.mark.parametrize("fault", [UnknownTypeError("no such type here"), GraphError("not today")])
async def test_pages_are_answered_where_the_graph_carries_no_rosapi(fault: Exception) -> None:
    log: list[tuple[Level, str]] = []
    on = GatewayGraph(Refusing(fault), TypeStore(Registry()))
    options = GatewayOptions(rosbridge="127.0.0.1:0")
    async with (
        rosbridge_gateway(options, on, lambda level, text: log.append((level, text))) as server,
        connect(server.uri) as client,
    ):
        await client.send('{"op": "call_service", "service": "/rosapi/nodes"}')
        assert json.loads(await client.recv())["values"] == {"nodes": ["/rosbridge_websocket"]}
    reason = f"rosbridge: only its own clients can call rosapi's services: {fault}"
    assert (Level.INFO, reason) in log


@pytest.mark.parametrize(
    ("place", "token", "line"),
    [
        (
            "localhost:0",
            "",
            (
                Level.INFO,
                "rosbridge: accepts connections from this machine only; "
                "--rosbridge 0.0.0.0:0 allows other machines",
            ),
        ),
        (
            "0.0.0.0:0",
            "",
            (
                Level.WARN,
                "rosbridge: every client that reaches it can publish and call services; "
                "--token and --allow restrict that",
            ),
        ),
        ("0.0.0.0:0", "abc", None),
    ],
)
async def test_it_reports_who_can_connect(place: str, token: str, line: tuple[Level, str] | None) -> None:
    log: list[tuple[Level, str]] = []
    on = GatewayGraph(MemoryNetwork().join, TypeStore(Registry()))
    options = GatewayOptions(rosbridge=place, token=token)
    async with rosbridge_gateway(options, on, lambda level, text: log.append((level, text))) as server:
        assert log[0] == (Level.INFO, f"rosbridge: web pages and programs connect to {server.uri}")
        assert log[1:] == ([line] if line is not None else [])


async def test_a_gateway_waits_for_a_missing_master(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.mechanisms.backoff.FIRST_RETRY_S", 0.001)
    log: list[tuple[Level, str]] = []
    away = MasterUnreachableError("the ROS master cannot be reached")
    join = Refusing(away, away, name="page")
    on = GatewayGraph(join, TypeStore(Registry()))
    graph = await joined_as(on, NodeNaming(), "page", lambda level, text: log.append((level, text)))
    assert log == [(Level.WARN, "page waits: the ROS master cannot be reached")]
    await graph.close()
