"""Compares the messages of rostether's gateway with those of Foxglove's server."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

from interop_web.web_peers import WebPeers
from programs import Peer
from rostether.graph.ports import ParamValue
from unit.gateways.foxglove.protocol_client import ProtocolClient, stage
from waiting import until

PARAMETERS: dict[str, ParamValue] = {
    "/bytes": b"\0\xff",
    "/float": 1.0,
    "/floats": [1.0, 2.5],
    "/int": 3,
    "/text": "text",
    "/tree": {"a": [1, True]},
    "/whole": 2.0,
}


async def use_all_operations(
    client: ProtocolClient, publish: Callable[[], Awaitable[None]]
) -> dict[str, Any]:
    """Use every operation once; return the answers without the ids, which the server chooses."""
    info = await client.wait("serverInfo")
    channel = await client.channel("/chatter")
    service = await client.service("/motor")
    await client.say("subscribe", subscriptions=[{"id": 4, "channelId": channel["id"]}])
    await client.say("getParameters", parameterNames=list(PARAMETERS), id="all")
    await client.say("subscribeConnectionGraph")
    await client.say("fetchAsset", uri="package://arm/mesh.stl", requestId=1)
    await client.say("fetchAsset", uri="package://arm/missing", requestId=2)
    await client.call(service["id"], b"\1")
    await client.wait("serviceCallResponse")
    await publish()
    message = await client.wait("messageData")
    answers = [await client.wait("fetchAssetResponse", partial(is_answer, number)) for number in (1, 2)]
    parameters = (await client.wait("parameterValues"))["parameters"]
    graph = await client.wait("connectionGraphUpdate")
    failures = await failure(client)
    return {
        "info": {name: info[name] for name in info if name not in ("sessionId", "metadata")},
        "channel": {name: channel[name] for name in channel if name != "id"},
        "service": {name: service[name] for name in service if name != "id"},
        "message": (message["id"], message["payload"]),
        "answer": {**client.of("serviceCallResponse")[0], "service": 0},
        "parameters": sorted(parameters, key=lambda each: str(each["name"])),
        "graph": sorted(graph),
        "assets": [(each["status"], each["data"], bool(each["error"])) for each in answers],
        "failure": sorted(failures),
    }


def is_answer(number: int, answer: dict[str, Any]) -> bool:
    return bool(answer["request"] == number)


async def failure(client: ProtocolClient) -> dict[str, Any]:
    await client.call(9999, b"", call_id=3)
    return await client.wait("serviceCallFailure")


async def test_the_gateway_sends_the_same_messages_as_the_sdk(web_peers: WebPeers, tmp_path: Path) -> None:
    (tmp_path / "mesh.stl").write_bytes(b"solid")
    async with stage(find_packages=lambda: {"arm": tmp_path}) as gateway, gateway.client() as client:
        registry = gateway.store.registry
        string, set_bool = registry.message_type("std_msgs/String"), registry.service_type("std_srvs/SetBool")

        async def handle(_: bytes) -> bytes:
            return b"\1\0\0\0\0"

        publisher = await gateway.robot.advertise("/chatter", string)
        await gateway.robot.advertise_service("/motor", set_bool, handle)
        for name, value in PARAMETERS.items():
            await gateway.robot.set_param(name, value)

        async def publish() -> None:
            await until(lambda: publisher.subscriber_count)
            publisher.publish_raw([b"\5\0\0\0hello"])

        gateway_messages = await use_all_operations(client, publish)
        offer = {
            "message": {"name": string.name, "text": string.definition},
            "request": {"name": set_bool.request.name, "text": set_bool.request.definition},
            "response": {"name": set_bool.response.name, "text": set_bool.response.definition},
        }
    sdk_messages = await use_sdk_server(await web_peers.start("foxglove_sdk_server.py"), offer)
    for each in (gateway_messages, sdk_messages):
        each["info"]["capabilities"] = set(each["info"]["capabilities"])
    assert gateway_messages == sdk_messages


async def use_sdk_server(server: Peer, offer: dict[str, Any]) -> dict[str, Any]:
    stdin = server.process.stdin
    assert stdin is not None
    stdin.write(json.dumps(offer).encode() + b"\n")
    await server.wait_for(lambda lines: bool(lines) and lines[-1].isdecimal())
    protocols = [Subprotocol("foxglove.sdk.v1")]
    url = f"ws://127.0.0.1:{server.lines[-1]}"
    client = ProtocolClient(await connect(url, subprotocols=protocols, proxy=None, compression=None))

    async def publish() -> None:
        stdin.write(b"\n")

    try:
        return await use_all_operations(client, publish)
    finally:
        await client.close()
