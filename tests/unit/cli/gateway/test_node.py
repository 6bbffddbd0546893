from __future__ import annotations

import asyncio

import click
import pytest

import rostether
from interop.ros1_peers import free_port
from programs import started
from rostether.cli.gateway.node import (
    NodeNaming,
    certificate_files,
    is_true,
    read_gateway_arguments,
    whole_number,
)
from rostether.errors import ConfigError
from rostether.ros1.master.server import MasterServer


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
