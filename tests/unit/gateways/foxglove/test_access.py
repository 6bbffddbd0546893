"""Who may connect to the gateway, and what each client may do."""

from __future__ import annotations

import asyncio
import struct

import pytest
from websockets.exceptions import InvalidHandshake, InvalidStatus

from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings, NameFilter
from unit.gateways.foxglove.protocol_client import STRING, stage, string_type, text
from waiting import until


async def test_a_foreign_page_and_a_wrong_token_are_refused() -> None:
    async with stage(FoxgloveSettings(port=0, token="secret")) as there:
        with pytest.raises(InvalidStatus):
            async with there.client():
                pass
        with pytest.raises(InvalidStatus):
            async with there.client(path="/?token=secret", origin="https://evil.example"):
                pass
        assert "--origin https://evil.example" in there.reported[-1]
        async with there.client(path="/?token=secret", origin="https://app.foxglove.dev") as client:
            await client.wait("serverInfo")


async def test_no_more_clients_than_allowed_and_a_free_place_is_taken() -> None:
    async with stage(FoxgloveSettings(port=0, limits=FoxgloveLimits(clients=1))) as there:
        async with there.client():
            with pytest.raises((OSError, InvalidHandshake)):
                async with there.client():
                    pass
            assert "the limit of clients (1) is reached" in there.reported[-1]
        await until(lambda: there.connection_count == 0)
        async with there.client() as client:
            await client.wait("serverInfo")


async def test_requests_sent_together_are_bounded() -> None:
    async with stage(FoxgloveSettings(port=0, limits=FoxgloveLimits(calls=3))) as there:
        calls: list[bytes] = []

        async def hang(request: bytes) -> bytes:
            calls.append(request)
            await asyncio.Event().wait()
            return b""

        service = there.store.registry.service_type("std_srvs/Empty")
        await there.robot.advertise_service("/hang", service, hang)
        async with there.client() as client:
            offered = await client.service("/hang")
            (inside,) = there.gateway._clients
            request = b"\x02" + struct.pack("<III", offered["id"], 1, 4) + b"ros1"
            for _ in range(5):
                inside.received(request)
            await until(lambda: len(client.of("serviceCallFailure")) == 2 and len(calls) == 3)


async def test_only_a_part_of_the_graph_is_offered_where_that_is_asked_for() -> None:
    settings = FoxgloveSettings(
        port=0,
        capabilities=("clientPublish", "parameters", "parametersSubscribe"),
        topics=NameFilter.of(["/open.*"], "test"),
        parameters=NameFilter.of(["/open"], "test"),
        client_topics=NameFilter.of(["/open_cmd"], "test"),
    )
    async with stage(settings) as there, there.client() as client:
        arrived: list[bytes] = []
        await there.robot.subscribe("/open_cmd", string_type(there), arrived.extend)
        await there.robot.subscribe("/cmd", string_type(there), arrived.extend)
        await there.robot.advertise("/hidden", string_type(there))
        await there.robot.advertise("/open", string_type(there))
        for name in ("/open", "/hidden"):
            await there.robot.set_param(name, 1)
        await client.channel("/open")
        assert [each["topic"] for message in client.of("advertise") for each in message["channels"]] == [
            "/open"
        ]
        await client.say("getParameters", parameterNames=[], id="all")
        answer = await client.wait("parameterValues")
        assert [each["name"] for each in answer["parameters"]] == ["/open"]
        await client.say("setParameters", parameters=[{"name": "/hidden", "value": 2}])
        await client.say("subscribeParameterUpdates", parameterNames=["/hidden"])
        channels = [
            {"id": number, "topic": topic, "encoding": "ros1", "schemaName": STRING}
            for number, topic in enumerate(("/cmd", "/open_cmd"))
        ]
        await client.say("advertise", channels=channels)
        await client.publish(1, text(there, "open"))
        await client.say("fetchAsset", uri="package://a/b", requestId=1)
        await client.say("subscribeConnectionGraph")
        await client.call(1, b"")
        await until(lambda: len(client.of("status")) == 6 and arrived)
        assert arrived == [text(there, "open")]
        assert await there.robot.get_param("/hidden") == 1
        assert not client.of("connectionGraphUpdate") + client.of("fetchAssetResponse")


async def test_a_client_with_the_view_token_looks_and_does_nothing_else() -> None:
    async with stage(FoxgloveSettings(port=0, token="full", view_token="look")) as there:
        service = there.store.registry.service_type("std_srvs/Empty")
        called: list[bytes] = []

        async def handle(request: bytes) -> bytes:
            called.append(request)
            return b""

        await there.robot.advertise_service("/home", service, handle)
        await there.robot.set_param("/speed", 1.5)
        async with there.client(path="/?token=full") as driver, there.client(path="/?token=look") as viewer:
            for client, rights in ((driver, "full"), (viewer, "view")):
                info = client.of("serverInfo")[0]
                assert info["metadata"]["rights"] == rights
                assert ("clientPublish" in info["capabilities"]) is (rights == "full")
                assert ("services" in info["capabilities"]) is (rights == "full")
            offered = await driver.service("/home")
            channel = {"id": 1, "topic": "/cmd", "encoding": "ros1", "schemaName": "std_msgs/Empty"}
            await viewer.say("advertise", channels=[channel | {"driver": "page"}])
            await viewer.say("advertise", channels=[channel])
            await viewer.publish(1, b"")
            await viewer.say("setParameters", parameters=[{"name": "/speed", "value": 9.0}], id="s")
            await until(lambda: len(viewer.of("status")) == 4)
            assert all("this connection may only view" in each["message"] for each in viewer.of("status"))
            await viewer.call(offered["id"], b"")
            failure = await viewer.wait("serviceCallFailure")
            assert "this connection may only view" in failure["message"]
            await viewer.say("getParameters", parameterNames=["/speed"], id="g")
            values = await viewer.wait("parameterValues")
            assert values["parameters"][0]["value"] == 1.5
            assert not viewer.of("advertiseServices")
            assert called == []
            assert "/cmd" not in there.network.snapshot().topics
            assert await there.robot.get_param("/speed") == 1.5


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=lookx", "/?token=full&token=look"])
async def test_the_view_token_is_asked_for_like_the_full_one(path: str) -> None:
    async with stage(FoxgloveSettings(port=0, token="full", view_token="look")) as there:
        if path.endswith("=full&token=look"):
            async with there.client(path=path) as client:
                assert client.of("serverInfo")[0]["metadata"]["rights"] == "full"
            return
        with pytest.raises(InvalidHandshake):
            async with there.client(path=path):
                pass
