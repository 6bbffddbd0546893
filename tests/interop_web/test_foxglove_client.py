"""Foxglove's client library with rostether's gateway, on ROS 1 and ROS 2 graphs."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from contract.implementations import IMPLEMENTATIONS
from interop_web.web_peers import WebPeers
from rostether.gateways.foxglove.gateway import FoxgloveGateway
from rostether.gateways.foxglove.server_messages import SUBPROTOCOLS
from rostether.gateways.foxglove.settings import CAPABILITIES, FoxgloveSettings
from rostether.graph.ports import JoinGraph
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.service_probe import probe_type
from rostether.serde.store import TypeStore
from waiting import until

STORE = TypeStore(Registry())
STRING = STORE.codec("std_msgs/String")


@asynccontextmanager
async def robot(join: JoinGraph, reported: list[str]) -> AsyncIterator[None]:
    """A node with a publisher, a subscriber, a service and a parameter."""
    graph = TypedGraph(await join("/robot"), STORE)
    latched = await graph.publisher("/latched", "std_msgs/String", latch=True)
    latched.publish(data="kept")
    await graph.publisher("/pose", "geometry_msgs/PoseStamped")
    count = await graph.publisher("/count", "std_msgs/UInt32")
    await graph.service_server(
        "/enable", "std_srvs/SetBool", lambda request: {"success": request.data, "message": "on"}
    )
    await graph.set_param("~speed", 1.5)
    await graph.set_param("~names", ["left", "right"])

    async def talk() -> None:
        number = 0
        while True:
            number += 1
            count.publish(data=number)
            await asyncio.sleep(0.005)

    async def listen() -> None:
        async for message in graph.messages("/said", "std_msgs/String"):
            reported.append(message.data)

    tasks = [asyncio.ensure_future(talk()), asyncio.ensure_future(listen())]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await graph.close()


async def probe(master_uri: str, service: str) -> str:
    client = MasterClient(master_uri, "/foxglove_bridge")
    try:
        return await probe_type(client, service)
    finally:
        await client.close()


@pytest.mark.parametrize(("ros", "protocol"), [("ros1", SUBPROTOCOLS[1]), ("zenoh", SUBPROTOCOLS[0])])
async def test_foxglove_client_uses_the_graph(
    ros: str, protocol: str, web_peers: WebPeers, tmp_path: Path
) -> None:
    model = tmp_path / "robot_model"
    (model / "meshes").mkdir(parents=True)
    (model / "meshes/arm.stl").write_text("solid arm")
    reported: list[str] = []
    async with IMPLEMENTATIONS[ros].open() as join, robot(join, reported):
        graph = await join("/foxglove_bridge")
        find = partial(probe, join.keywords["environment"].master_uri) if isinstance(join, partial) else None
        gateway = FoxgloveGateway(
            graph,
            STORE,
            FoxgloveSettings(port=0),
            find_service_type=find,
            find_packages=lambda: {"robot_model": model},
        )
        async with gateway:
            output = await web_peers.run(
                "foxglove_client.mjs", f"ws://127.0.0.1:{gateway.port}", protocol, timeout_s=180
            )
            await until(lambda: len(reported) >= 2)
        await graph.close()
    check_found([json.loads(line) for line in output.splitlines()], reported)


def check_found(lines: list[dict[str, Any]], reported: list[str]) -> None:
    assert not [line for line in lines if "error" in line]
    found = {line["check"]: line["found"] for line in lines}
    assert found["greeting"] == {
        "name": "rostether",
        "capabilities": list(CAPABILITIES),
        "supportedEncodings": ["ros1", "json"],
    }
    assert found["channel"] == {
        "topic": "/latched",
        "encoding": "ros1",
        "schemaName": "std_msgs/String",
        "schemaEncoding": "ros1msg",
        "schema": "string data\n",
    }
    assert found["nestedSchema"] == STORE.registry.message_type("geometry_msgs/PoseStamped").definition
    assert found["latched"] == {"isNow": True, "payload": STRING.encode({"data": "kept"}).hex()}
    assert found["manyInOrder"] is True
    assert sorted(reported) == ["json", "raw"]
    assert (found["service"]["type"], found["service"]["request"]["schema"]) == (
        "std_srvs/SetBool",
        "bool data\n",
    )
    answer = STORE.codec("std_srvs/SetBoolResponse").encode({"success": True, "message": "on"})
    assert found["call"] == {"encoding": "ros1", "response": answer.hex()}
    assert json.loads(found["callJson"]["response"]) == {"success": True, "message": "on"}
    assert "SetBool" in found["callBroken"]["failure"]
    assert {"name": "/robot/speed", "value": 1.5, "type": "float64"} in found["parameters"]
    assert {"name": "/robot/names", "value": ["left", "right"]} in found["parameters"]
    assert found["setParameter"] == [{"name": "/robot/speed", "value": 2.5, "type": "float64"}]
    assert found["asset"] == {"status": 0, "data": "solid arm"}
    assert found["assetOutside"] == 1
    assert found["connectionGraph"] == {
        "latched": ["/robot"],
        "said": ["/robot"],
        "enable": ["/robot"],
    }
    assert found["mistakes"] == []
