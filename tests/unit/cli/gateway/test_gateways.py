from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping

import click
import pytest
from websockets.asyncio.client import connect

import rostether
from interop.ros1_peers import free_port
from programs import started
from rostether.cli.gateway.gateways import (
    GatewayGraph,
    NodeNaming,
    certificate_files,
    is_true,
    joined_as,
    read_gateway_arguments,
    whole_number,
)
from rostether.cli.gateway.options import GatewayOptions
from rostether.cli.gateway.rosbridge import rosbridge_gateway
from rostether.errors import ConfigError, GraphError, MasterUnreachableError, UnknownTypeError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.ros1.master.server import MasterServer
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
    monkeypatch.setattr("rostether.mechanisms.waiting.FIRST_RETRY_S", 0.001)
    log: list[tuple[Level, str]] = []
    away = MasterUnreachableError("the ROS master cannot be reached")
    join = Refusing(away, away, name="page")
    on = GatewayGraph(join, TypeStore(Registry()))
    graph = await joined_as(on, NodeNaming(), "page", lambda level, text: log.append((level, text)))
    assert log == [(Level.WARN, "page waits: the ROS master cannot be reached")]
    await graph.close()


def test_a_port_other_than_the_default_is_in_the_name() -> None:
    assert NodeNaming().name_for("bridge", 9090, 9090) == "bridge"
    assert NodeNaming().name_for("bridge", 0, 9090) == "bridge"
    assert NodeNaming().name_for("bridge", 9091, 9090) == "bridge_9091"
    assert NodeNaming(name="mine").name_for("bridge", 9091, 9090) == "mine"


def test_gateway_arguments() -> None:
    assert read_gateway_arguments([], {}) == ("localhost", NodeNaming())
    address, naming = read_gateway_arguments(["/a:=/b", "0.0.0.0:9091"], {"__name": "panel"})
    assert address == "0.0.0.0:9091"
    assert naming.remappings == {"/a": "/b"}
    assert naming.name == "panel"
    with pytest.raises(click.UsageError, match=r"only one \[HOST:\]PORT, not 9091 and 9092"):
        read_gateway_arguments(["9091", "9092"], {})
    with pytest.raises(click.UsageError, match="_port:= works only for the node in launch files"):
        read_gateway_arguments(["_port:=9091"], {})
    with pytest.raises(ConfigError):
        read_gateway_arguments(["a:=b c"], {})


async def test_a_second_gateway_ends_no_other_and_a_killed_one_is_replaced() -> None:
    port = str(free_port())
    master = await MasterServer.start(port=0)
    to_master = ("--master", master.uri)
    try:
        async with started("rosbridge", port, *to_master) as first:
            await first.wait_for("allows other machines")
            named = ("__name:=web", "__ns:=lab", *to_master)
            async with started("rosbridge", "0", *named) as second:
                await second.wait_for("allows other machines")
                async with started(
                    "foxglove", "0", f"__name:=rosbridge_websocket_{port}", *to_master
                ) as third:
                    await third.wait_for(
                        f"a node /rosbridge_websocket_{port} is already running; stop it, or"
                    )
                    assert await third.process.wait() == 1
                async with rostether.join("/asking", master=master.uri) as graph:
                    gateways = {"/rosapi", f"/rosbridge_websocket_{port}", "/lab/web"}
                    async with asyncio.timeout(60):
                        while not gateways <= set((await graph.call("/rosapi/nodes", "rosapi/Nodes")).nodes):
                            await asyncio.sleep(0.02)
            first.process.kill()
            await first.process.wait()
        async with started("rosbridge", port, *to_master) as again:
            await again.wait_for("allows other machines")
            async with rostether.join("/asking", master=master.uri) as graph:
                answer = await graph.call("/rosapi/nodes", "rosapi/Nodes")
                assert f"/rosbridge_websocket_{port}" in answer.nodes
    finally:
        await master.close()


@pytest.mark.parametrize(
    ("value", "is_set"),
    [(True, True), ("True", True), (" yes ", True), (1, True), (False, False), ("no", False), (None, False)],
)
def test_flags(value: object, is_set: bool) -> None:
    assert is_true({"on": value}, "on") is is_set
    assert not is_true({}, "on")


@pytest.mark.parametrize(("value", "number"), [(7, 7), (" 7 ", 7), (0, 0), (None, 5), ("", 5), ("None", 5)])
def test_whole_numbers_and_unset_values(value: object, number: int) -> None:
    assert whole_number({"size": value}, "size", 5) == number
    assert whole_number({}, "size", 5) == 5


@pytest.mark.parametrize("value", ["many", -1, 1.5, True, [], "1e3"])
def test_values_that_are_not_whole_numbers_are_named(value: object) -> None:
    with pytest.raises(ConfigError, match="~size must be a whole number, not "):
        whole_number({"size": value}, "size", 5)


def test_a_certificate_is_needed_for_encryption() -> None:
    assert certificate_files({"certfile": "a.pem", "keyfile": None}, "tls") == ("a.pem", "")
    assert certificate_files({"certfile": "a.pem", "keyfile": "b.pem"}, "tls") == ("a.pem", "b.pem")
    with pytest.raises(ConfigError, match="~tls needs ~certfile and ~keyfile"):
        certificate_files({"keyfile": "b.pem"}, "tls")
