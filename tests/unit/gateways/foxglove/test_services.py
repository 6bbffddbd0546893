"""Services that Foxglove clients call, over real sockets."""

from __future__ import annotations

import json
from functools import partial
from typing import Any

from rostether.errors import ServiceCallError
from rostether.graph.ports import ServiceEntry, Snapshot
from unit.gateways.foxglove.protocol_client import stage

SET_BOOL = "std_srvs/SetBool"


async def test_a_client_calls_services() -> None:
    async with stage() as there, there.client() as client:
        codec = there.store.codec("std_srvs/SetBoolResponse")

        async def handle(request: bytes) -> bytes:
            if request == b"\0":
                raise ServiceCallError("the motor is blocked")
            return codec.encode({"success": True, "message": "on"})

        await there.robot.advertise_service("/motor", there.store.registry.service_type(SET_BOOL), handle)
        service = await client.service("/motor")
        assert service["type"] == SET_BOOL
        assert service["request"]["schema"] == "bool data\n"
        await client.call(service["id"], b"\1")
        answer = await client.wait("serviceCallResponse")
        assert codec.decode(answer["payload"]) == codec.conform({"success": True, "message": "on"})
        await client.call(service["id"], b'{"data": true}', encoding="json", call_id=8)
        answer = await client.wait("serviceCallResponse", lambda message: message["call"] == 8)
        assert json.loads(answer["payload"]) == {"success": True, "message": "on"}
        for call_id, payload, reason in ((1, b"\0", "blocked"), (2, b"", "SetBool"), (3, b"\1\2", "SetBool")):
            await client.call(service["id"], payload, call_id=call_id)
            await client.wait("serviceCallFailure", partial(answers, call_id))
            assert reason in client.of("serviceCallFailure")[-1]["message"]
        await client.call(999, b"", call_id=4)
        await client.wait("serviceCallFailure", lambda each: each["callId"] == 4)


def answers(call_id: int, failure: dict[str, Any]) -> bool:
    return bool(failure["callId"] == call_id)


async def test_service_types_are_requested_if_the_graph_does_not_know_them() -> None:
    asked: list[str] = []

    async def find(name: str) -> str:
        asked.append(name)
        return SET_BOOL

    async with stage(find_service_type=find) as there, there.client() as client:
        services = there.gateway.context.services
        snapshot = await there.robot.snapshot()

        async def handle(request: bytes) -> bytes:
            return b"\1\0\0\0\0"

        await there.robot.advertise_service("/known", there.store.registry.service_type(SET_BOOL), handle)
        await client.service("/known")
        untyped = {"/asked": ServiceEntry("/asked", ("/robot",))}
        services.update(Snapshot(snapshot.nodes, snapshot.topics, untyped))
        assert (await client.service("/asked"))["type"] == SET_BOOL
        assert asked == ["/asked"]
