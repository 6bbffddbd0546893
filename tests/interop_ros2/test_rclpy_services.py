"""Services and parameters between a node of rostether over rclpy and a plain rclpy node in another
process.
"""

from __future__ import annotations

import asyncio

import pytest

from contract.graphs import TRUE, wait_for_service
from interop_ros2.rclpy_peer import PEER_NAME, RclpyPeer
from rostether.errors import ServiceTimeoutError, SessionError, TypeMismatchError, UnknownTypeError
from rostether.graph.ports import JoinGraph, ParamValue
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.ros2.parameters.client import ParameterClient
from rostether.ros2.parameters.typed_value import ParameterType, typed_value
from rostether.serde.store import TypeStore
from waiting import until

pytestmark = [pytest.mark.rclpy, pytest.mark.asyncio(loop_scope="module")]

SERVICES = {
    "std_srvs/SetBool": ({"data": True}, {"success": True, "message": "äh"}),
    "std_srvs/Trigger": ({}, {"success": False, "message": "no"}),
}


async def test_parameters_that_are_set_are_described(
    join: JoinGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A busy machine may need longer than users wait.
    monkeypatch.setattr("rostether.ros2.parameters.client.CALL_TIMEOUT_S", 60)
    node, client_node = await join("/described"), await join("/asker")
    await node.set_param("~gain", 1.5)
    client = ParameterClient(client_node)
    # Another node sets it, without a declaration.
    await client.set("/described", {"name": typed_value("name", "arm")})
    described = await client.describe("/described", ["gain", "name"])
    assert [(each.name, each.type, each.dynamic_typing) for each in described] == [
        ("gain", ParameterType.DOUBLE, True),
        ("name", ParameterType.STRING, True),
    ]


def ros2_service(name: str) -> str:
    return name.replace("/", "/srv/")


@pytest.mark.parametrize("name", SERVICES)
async def test_rclpy_client_to_server(join: JoinGraph, peer: RclpyPeer, store: TypeStore, name: str) -> None:
    node = await join("/board")
    request, response = SERVICES[name]
    received = []

    async def handle(payload: bytes) -> bytes:
        received.append(payload)
        return store.codec(f"{name}Response").encode(response)

    service = f"/rostether/{name.replace('/', '_')}"
    server = await node.advertise_service(service, store.registry.service_type(name), handle)
    assert await peer.ask("call", service=service, type=ros2_service(name), request=request) == response
    assert received == [store.codec(f"{name}Request").encode(request)]
    await server.close()


@pytest.mark.parametrize("name", SERVICES)
async def test_client_to_rclpy_server(join: JoinGraph, peer: RclpyPeer, store: TypeStore, name: str) -> None:
    request, response = SERVICES[name]
    service = f"/rclpy/{name.replace('/', '_')}"
    await peer.ask("serve", service=service, type=ros2_service(name), response=response)
    node = await join("/board")
    payload = store.codec(f"{name}Request").encode(request)
    received = await node.call_service(service, store.registry.service_type(name), payload, timeout_s=60)
    assert received == store.codec(f"{name}Response").encode(response)
    (seen,) = await peer.ask("received_requests", service=service)
    assert seen == request or not request


async def test_a_call_of_another_type_is_refused(join: JoinGraph, peer: RclpyPeer, store: TypeStore) -> None:
    await peer.ask("serve", service="/rclpy/typed", type="std_srvs/srv/SetBool", response={})
    node = await join("/board")
    while "/rclpy/typed" not in (await node.snapshot()).services:
        await asyncio.sleep(0.01)
    reported = "/rclpy/typed is std_srvs/srv/SetBool, not std_srvs/srv/Trigger"
    with pytest.raises(TypeMismatchError, match=reported):
        await node.call_service("/rclpy/typed", store.registry.service_type("std_srvs/Trigger"), b"")


async def test_a_failing_handler_sends_no_answer_and_reports_the_reason(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    node = await join("/board")

    async def refuse(_: bytes) -> bytes:
        raise SessionError("the board is away")

    await node.advertise_service(
        "/rostether/refusing", store.registry.service_type("std_srvs/Trigger"), refuse
    )
    call = {"service": "/rostether/refusing", "type": "std_srvs/srv/Trigger", "request": {}}
    assert await peer.ask("call", **call, timeout_s=0.3) is None
    await until(lambda: "no answer to a call of /rostether/refusing: the board is away" in caplog.text)


async def test_all_calls_of_a_burst_are_answered(join: JoinGraph, store: TypeStore) -> None:
    node, other = await join("/board"), await join("/other")

    async def handle(_: bytes) -> bytes:
        return b"\1\0\0\0\0"

    set_bool = store.registry.service_type("std_srvs/SetBool")
    await node.advertise_service("/rostether/busy", set_bool, handle)
    calls = [other.call_service("/rostether/busy", set_bool, TRUE, timeout_s=60) for _ in range(60)]
    assert set(await asyncio.gather(*calls)) == {b"\1\0\0\0\0"}


async def test_a_server_that_does_not_answer_times_out(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore
) -> None:
    node, other = await join("/board"), await join("/other")

    async def hang(_: bytes) -> bytes:
        await asyncio.Event().wait()
        raise AssertionError("unreachable")

    set_bool = store.registry.service_type("std_srvs/SetBool")
    await node.advertise_service("/rostether/hanging", set_bool, hang)
    await wait_for_service(other, "/rostether/hanging")
    with pytest.raises(ServiceTimeoutError, match=r"/rostether/hanging did not answer within 0.2 s"):
        await other.call_service("/rostether/hanging", set_bool, TRUE, timeout_s=0.2)


async def test_a_service_type_that_is_not_installed_is_refused(join: JoinGraph) -> None:
    node = await join("/board")
    request_type = MessageType("my_robot_srvs/FlyRequest", "0" * 32, "float32 height\n")
    fly = ServiceType(
        "my_robot_srvs/Fly", "0" * 32, request_type, MessageType("my_robot_srvs/FlyResponse", "1" * 32)
    )
    with pytest.raises(UnknownTypeError, match="the package my_robot_srvs is not installed"):
        await node.call_service("/fly", fly, b"\0\0\0\0")


PARAMETERS: dict[str, ParamValue] = {
    "flag": True,
    "count": 7,
    "gain": 0.5,
    "name": "ärm",
    "flags": [True, False],
    "counts": [1, -2],
    "gains": [0.5, 1.5],
    "names": ["a", "b"],
}


async def test_rclpy_sets_and_reads_parameters_of_a_node(join: JoinGraph, peer: RclpyPeer) -> None:
    node = await join("/tuned")
    seen: list[ParamValue] = []
    await node.watch_param("~arm/gain", seen.append)
    await peer.ask(
        "parameters",
        node="/tuned",
        method="set_parameters",
        arguments=[(f"arm.{name}", value) for name, value in PARAMETERS.items()],
    )
    assert await node.get_param("~arm") == PARAMETERS
    assert await node.get_param("/tuned/arm/gain") == 0.5
    await until(lambda: seen[-1] == 0.5)
    await node.set_param("~arm/gain", 0.75)
    reply = await peer.ask("parameters", node="/tuned", method="get_parameters", arguments=["arm.gain"])
    assert reply["values"][0]["double_value"] == 0.75


async def test_parameters_that_a_board_reads_are_listed(join: JoinGraph, peer: RclpyPeer) -> None:
    node = await join("/asking")
    assert not await node.has_param("~baud")
    with pytest.raises(LookupError):
        await node.get_param("~baud")
    reply = await peer.ask("parameters", node="/asking", method="list_parameters", arguments=[])
    while "baud" not in reply["result"]["names"]:
        reply = await peer.ask("parameters", node="/asking", method="list_parameters", arguments=[])
    assert not await node.has_param("~baud")
    await peer.ask("parameters", node="/asking", method="set_parameters", arguments=[("baud", 57600)])
    assert await node.get_param("~baud") == 57600


async def test_parameters_of_rclpy(join: JoinGraph, peer: RclpyPeer) -> None:
    node = await join("/board")
    for name, value in PARAMETERS.items():
        await peer.ask("set_own_parameter", name=f"far.{name}", value=value)
    while PEER_NAME not in (await node.snapshot()).nodes:
        await asyncio.sleep(0.01)
    for name, value in PARAMETERS.items():
        assert await node.get_param(f"{PEER_NAME}/far/{name}") == value
    await node.set_param(f"{PEER_NAME}/far/gain", 2.0)
    assert await peer.ask("get_own_parameter", name="far.gain") == 2.0
    assert f"{PEER_NAME}/far/gain" in await node.list_params()
    seen: list[ParamValue] = []
    await node.watch_param(f"{PEER_NAME}/far/count", seen.append)
    await peer.ask("set_own_parameter", name="far.count", value=8)
    await until(lambda: seen == [7, 8])
