"""Services that rosbridge clients call and offer."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from rostether.errors import ServiceCallError
from rostether.gateways.rosbridge import client_services
from rostether.serde.values import Message
from unit.gateways.rosbridge.web_client import World
from waiting import until


async def test_services_are_called_by_fields_by_order_and_by_a_single_value(there: World) -> None:
    async def enable(request: Message) -> dict[str, Any]:
        return {"success": request.data, "message": "done"}

    await there.graph.service_server("/enable", "std_srvs/SetBool", enable)
    async with there.client() as client:
        for args in ({"data": True}, [True], True):
            await client.say("call_service", service="/enable", args=args, id="c")
            assert await client.receive() == {
                "op": "service_response",
                "service": "/enable",
                "id": "c",
                "values": {"success": True, "message": "done"},
                "result": True,
            }
        await client.say("call_service", service="enable")
        answer = await client.receive("service_response")
        assert "id" not in answer
        assert answer["values"]["success"] is False
        mistakes: list[tuple[Any, str]] = [
            ({"date": True}, "std_srvs/SetBoolRequest has no field date; it has data"),
            ({"data": "yes"}, 'std_srvs/SetBoolRequest needs a bool for field data, got "yes"'),
            ([True, 1], "call_service: std_srvs/SetBoolRequest has 1 field, but args has 2 values"),
        ]
        for args, reason in mistakes:
            await client.say("call_service", service="/enable", args=args)
            answer = await client.receive("service_response")
            assert (answer["result"], answer["values"]) == (False, reason)
        await client.say("call_service", service="/nothing")
        assert (await client.receive())[
            "values"
        ] == "service /nothing does not exist; check that its node is running"
        await client.say("call_service", service="no name", id="n")
        assert (await client.receive("service_response"))["result"] is False


async def test_a_long_call_delays_nothing_and_ends_at_its_time_limit(there: World) -> None:
    called = asyncio.Event()

    async def hang(request: Message) -> dict[str, Any]:
        called.set()
        await asyncio.sleep(3600)
        return {}

    await there.graph.service_server("/hang", "std_srvs/Trigger", hang)
    async with there.client() as client:
        await client.say("call_service", service="/hang", id="long")
        await client.say("call_service", service="/hang", id="short", timeout=0.05)
        answer = await client.receive("service_response")
        assert answer["id"] == "short"
        assert answer["values"].startswith("service /hang did not answer within 0.05 s; check that its node")
        await called.wait()
    # A client that closes its connection during a call leaves nothing behind.
    await there.wait_until_all_left()


async def test_calls_that_never_end_hold_up_nothing_else(
    there: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(client_services, "MAX_CALLS", 2)

    async def hang(request: Message) -> dict[str, Any]:
        await asyncio.sleep(3600)
        return {}

    await there.graph.service_server("/hang", "std_srvs/Trigger", hang)
    async with there.client() as client:
        for number in range(3):
            await client.say("call_service", service="/hang", id=number)
        refused = await client.receive("service_response")
        assert refused["id"] == 2
        assert (
            refused["values"] == "this client has 2 pending calls; wait for a response before you call /hang"
        )
        await client.say("publish", topic="/nobody", msg={})
        assert "advertise it first" in (await client.receive("status"))["msg"]


async def test_what_calls_hold_is_bounded(there: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client_services, "MAX_QUEUED_BYTES", 1000)
    go_on = asyncio.Event()

    async def hang(request: Message) -> dict[str, Any]:
        await go_on.wait()
        return {}

    await there.graph.service_server("/hang", "std_srvs/Trigger", hang)
    async with there.client() as client:
        for number in range(2):
            await client.say("call_service", service="/hang", id=number, filler="x" * 900)
        refused = await client.receive("service_response")
        assert (refused["id"], refused["result"]) == (1, False)
        assert "bytes of pending calls; wait for a response before you call /hang" in refused["values"]
        go_on.set()
        assert (await client.receive("service_response"))["id"] == 0
        await client.say("call_service", service="/hang", id=2, filler="x" * 2000)
        assert (await client.receive("service_response"))["result"] is True


async def test_a_client_serves_and_its_faults_reach_the_caller(there: World) -> None:
    async with there.client() as client:
        await client.say("advertise_service", service="/add", type="std_srvs/SetBool")
        await client.settled()

        async def call(**answer: Any) -> Message:
            calling = asyncio.ensure_future(
                there.graph.call("/add", "std_srvs/SetBool", {"data": True}, timeout_s=60)
            )
            request = await client.receive("call_service")
            assert request["service"] == "/add"
            assert request["args"] == {"data": True}
            await client.say("service_response", service="/add", id=request["id"], **answer)
            return await calling

        answer = await call(values={"success": True, "message": "ok"}, result=True)
        assert (answer.success, answer.message) == (True, "ok")
        with pytest.raises(ServiceCallError, match="no battery"):
            await call(values="no battery", result=False)
        with pytest.raises(ServiceCallError, match=r"no \\ud800 power"):
            await call(values="no \ud800\npower", result=False)
        with pytest.raises(ServiceCallError, match="field success"):
            await call(values={"success": "maybe"}, result=True)
        assert "field success" in (await client.receive("status"))["msg"]
        await client.say("service_response", service="/add", id="made up", values={}, result=True)
        assert 'no call of /add has the id "made up"' in (await client.receive("status"))["msg"]
        calling = asyncio.ensure_future(there.graph.call("/add", "std_srvs/SetBool", timeout_s=60))
        await client.receive("call_service")
        await client.say("unadvertise_service", service="/add")
        with pytest.raises(ServiceCallError, match="was unadvertised while it was called"):
            await calling


async def test_a_client_that_hangs_up_fails_the_calls_that_it_was_to_answer(there: World) -> None:
    async with there.client() as client:
        await client.say("advertise_service", service="/add", type="std_srvs/SetBool")
        await client.settled()
        calling = asyncio.ensure_future(there.graph.call("/add", "std_srvs/SetBool", timeout_s=60))
        await client.receive("call_service")
        client.connection.transport.abort()
    with pytest.raises(ServiceCallError, match="ended: the client that offers it has disconnected"):
        await calling
    await until(lambda: "/add" not in there.network.snapshot().services)


async def test_a_page_that_was_loaded_again_gets_its_service_back(there: World) -> None:
    async with there.client() as old, there.client() as new:
        await old.say("advertise_service", service="/add", type="std_srvs/SetBool")
        await old.settled()
        await new.say("advertise_service", service="/add", type="std_srvs/SetBool")
        assert "was offered by another client" in (await new.settled())[0]["msg"]
        calling = asyncio.ensure_future(there.graph.call("/add", "std_srvs/SetBool", timeout_s=60))
        request = await new.receive("call_service")
        await new.say("service_response", service="/add", id=request["id"], values={}, result=True)
        await calling
