"""A gateway and its clients, over real sockets."""

from __future__ import annotations

import asyncio
import json
import socket
import struct
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import InvalidHandshake, InvalidStatus

from rostether.errors import ServiceCallError, TransportOpenError
from rostether.gateways.foxglove.gateway import FoxgloveGateway
from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings, NameFilter
from rostether.graph.ports import ServiceEntry, Snapshot
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from unit.gateways.foxglove.protocol_client import Stage, stage
from waiting import until

STRING, SET_BOOL = "std_msgs/String", "std_srvs/SetBool"


def text(stage: Stage, data: str) -> bytes:
    return stage.store.codec(STRING).encode({"data": data})


def string_type(stage: Stage) -> MessageType:
    return stage.store.registry.message_type(STRING)


@pytest.mark.parametrize("protocol", ["foxglove.sdk.v1", "foxglove.websocket.v1"])
async def test_a_client_is_greeted_and_shown_the_graph(protocol: str) -> None:
    async with stage() as there:
        await there.robot.advertise("/chatter", string_type(there))
        async with there.client(protocol) as client:
            info = await client.wait("serverInfo")
            assert client.connection.subprotocol == protocol
            assert info["supportedEncodings"] == ["ros1", "json"]
            assert "time" not in info["capabilities"]
            channel = await client.channel("/chatter")
            assert (channel["encoding"], channel["schemaEncoding"]) == ("ros1", "ros1msg")
            assert (channel["schemaName"], channel["schema"]) == (STRING, "string data\n")


async def test_messages_come_as_they_are_only_while_subscribed() -> None:
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", string_type(there))
        channel = await client.channel("/chatter")
        assert publisher.subscriber_count == 0
        await client.say("subscribe", subscriptions=[{"id": 5, "channelId": channel["id"]}])
        await until(lambda: publisher.subscriber_count)
        payloads = [text(there, "x" * size) for size in (0, 100, 200, 70_000)]
        publisher.publish_raw(payloads)
        await client.wait("messageData", lambda message: message["payload"] == payloads[-1])
        arrived = client.of("messageData")
        assert [message["payload"] for message in arrived] == payloads
        assert {message["id"] for message in arrived} == {5}
        await client.say("unsubscribe", subscriptionIds=[5])
        await until(lambda: publisher.subscriber_count == 0)


async def test_a_late_client_gets_what_was_latched_and_the_first_does_not_again() -> None:
    async with stage() as there, there.client() as first:
        publisher = await there.robot.advertise("/map", string_type(there), latch=True)
        publisher.publish_raw([text(there, "map")])
        channel = await first.channel("/map")
        await first.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        await first.wait("messageData")
        async with there.client() as second:
            await second.say("subscribe", subscriptions=[{"id": 9, "channelId": channel["id"]}])
            assert (await second.wait("messageData"))["id"] == 9
        await until(lambda: there.gateway.client_count == 1)
        assert publisher.subscriber_count == 1
        assert len(first.of("messageData")) == 1


async def test_a_topic_that_ends_is_taken_back_with_its_subscriptions() -> None:
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", string_type(there))
        channel = await client.channel("/chatter")
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        await until(lambda: publisher.subscriber_count)
        await publisher.close()
        await client.wait("unadvertise", lambda message: message["channelIds"] == [channel["id"]])
        await until(lambda: not there.gateway.shared.topics)
        await there.robot.advertise("/chatter", string_type(there))
        again = await client.channel("/chatter", after=channel["id"])
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": again["id"]}])
        await until(lambda: there.gateway.shared.topics)


async def test_a_type_that_is_not_known_is_learned_from_its_publisher() -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("mine/Odd", "int32 a\nmine/Part part\n" + "=" * 80 + "\nMSG: mine/Part\nuint8 b\n")
    odd = registry.message_type("mine/Odd")
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/odd", odd)
        channel = await client.channel("/odd")
        assert channel["schema"] == odd.definition
        await until(lambda: publisher.subscriber_count == 0)
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        await until(lambda: publisher.subscriber_count)
        publisher.publish_raw([b"\1\0\0\0\2"])
        assert (await client.wait("messageData"))["payload"] == b"\1\0\0\0\2"


async def test_a_publisher_with_another_definition_gets_a_channel_of_its_definition() -> None:
    registry = Registry(bundled=False)
    registry.add_full_text(STRING, "int32 number\n")
    other = registry.message_type(STRING)
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", other)
        channel = await client.channel("/chatter")
        assert channel["schema"] == "string data\n"
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        again = await client.channel("/chatter", after=channel["id"])
        assert again["schema"] == "int32 number\n"
        await client.say("subscribe", subscriptions=[{"id": 2, "channelId": again["id"]}])

        def is_received() -> bool:
            # The subscription of the channel that has ended may still be there.
            publisher.publish_raw([b"\1\0\0\0"])
            return bool(client.of("messageData"))

        await until(is_received)
        assert {each["id"] for each in client.of("messageData")} == {2}


async def test_a_client_publishes_raw_and_json() -> None:
    async with stage() as there, there.client() as client:
        arrived: list[bytes] = []
        await there.robot.subscribe("/cmd", string_type(there), arrived.extend)
        channels = [
            {"id": 1, "topic": "/cmd", "encoding": "ros1", "schemaName": STRING},
            {"id": 2, "topic": "/cmd", "encoding": "json", "schemaName": "std_msgs/msg/String"},
        ]
        await client.say("advertise", channels=channels)
        # At once: what comes before the graph has taken the topic is kept.
        await client.publish(1, text(there, "raw"))
        await client.publish(2, b'{"data": "json"}')
        await until(lambda: len(arrived) == 2)
        assert sorted(arrived) == sorted([text(there, "raw"), text(there, "json")])
        await client.publish(1, b"\xff\xff\xff\xff")
        assert "/cmd is not published" in (await client.wait("status"))["message"]
        await client.say("unadvertise", channelIds=[1, 2])
        await client.wait("unadvertise")
    assert len(arrived) == 2


async def test_messages_sent_before_a_client_leaves_are_published() -> None:
    async with stage() as there, there.client() as client:
        arrived: list[bytes] = []
        await there.robot.subscribe("/said", string_type(there), arrived.extend)
        channel = {"id": 1, "topic": "/said", "encoding": "ros1", "schemaName": STRING}
        await client.say("advertise", channels=[channel])
        await client.publish(1, text(there, "bye"))
        await client.say("unadvertise", channelIds=[1])
        await until(lambda: arrived == [text(there, "bye")])


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
        services = there.gateway.services
        snapshot = await there.robot.snapshot()

        async def handle(request: bytes) -> bytes:
            return b"\1\0\0\0\0"

        await there.robot.advertise_service("/known", there.store.registry.service_type(SET_BOOL), handle)
        await client.service("/known")
        untyped = {"/asked": ServiceEntry("/asked", ("/robot",))}
        services.update(Snapshot(snapshot.nodes, snapshot.topics, untyped))
        assert (await client.service("/asked"))["type"] == SET_BOOL
        assert asked == ["/asked"]


async def test_parameters_are_got_set_and_watched() -> None:
    async with stage() as there, there.client() as client:
        await there.robot.set_param("/speed", 1.0)
        await there.robot.set_param("/arm/names", ["a", "b"])
        await client.say("getParameters", parameterNames=[], id="all")
        answer = await client.wait("parameterValues", lambda each: each.get("id") == "all")
        values = {each["name"]: each for each in answer["parameters"]}
        assert values["/arm/names"]["value"] == ["a", "b"]
        assert values["/speed"] == {"name": "/speed", "value": 1.0, "type": "float64"}
        await client.say("subscribeParameterUpdates", parameterNames=["/speed"])
        await client.say("setParameters", parameters=[{"name": "/speed", "value": 3}], id="set")
        answer = await client.wait("parameterValues", lambda each: each.get("id") == "set")
        assert answer["parameters"] == [{"name": "/speed", "value": 3.0, "type": "float64"}]
        # What was a float is one still: on ROS 2 its type is fixed.
        assert isinstance(await there.robot.get_param("/speed"), float)
        await client.wait(
            "parameterValues", lambda each: "id" not in each and each["parameters"][0]["value"] == 3.0
        )
        await there.robot.set_param("/speed", 4.5)
        await client.wait("parameterValues", lambda each: each["parameters"][0]["value"] == 4.5)
        await client.say("setParameters", parameters=[{"name": "/speed"}], id="unset")
        await client.wait("parameterValues", lambda each: each.get("id") == "unset")
        assert not await there.robot.has_param("/speed")
        await client.say("getParameters", parameterNames=["/speed", "/arm/names"], id="some")
        answer = await client.wait("parameterValues", lambda each: each.get("id") == "some")
        assert [each["name"] for each in answer["parameters"]] == ["/arm/names"]


async def test_no_names_are_all_parameters_to_watch_and_to_forget() -> None:
    async with stage() as there, there.client() as client:
        await there.robot.set_param("/a", 1)
        await there.robot.set_param("/b", 2)
        await client.say("subscribeParameterUpdates", parameterNames=[])

        def reported(name: str, value: int) -> bool:
            output = [each for message in client.of("parameterValues") for each in message["parameters"]]
            return {"name": name, "value": value} in output

        await until(lambda: reported("/a", 1) and reported("/b", 2))
        await there.robot.set_param("/b", 3)
        await until(lambda: reported("/b", 3))
        await client.say("unsubscribeParameterUpdates", parameterNames=[])
        await client.say("getParameters", parameterNames=["/a"], id="done")
        await client.wait("parameterValues", lambda each: each.get("id") == "done")
        await there.robot.set_param("/a", 4)
        await client.say("getParameters", parameterNames=["/b"], id="later")
        await client.wait("parameterValues", lambda each: each.get("id") == "later")
        assert not reported("/a", 4)


async def test_the_connection_graph_comes_whole_and_then_in_changes() -> None:
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", string_type(there))
        await client.channel("/chatter")
        await client.say("subscribeConnectionGraph")
        whole = await client.wait("connectionGraphUpdate")
        assert {"name": "/chatter", "publisherIds": ["/robot"]} in whole["publishedTopics"]
        await publisher.close()
        await client.wait("connectionGraphUpdate", lambda each: each["removedTopics"] == ["/chatter"])


async def test_simulated_time_is_sent_and_stamps_messages() -> None:
    async with stage() as there:
        clock_type = there.store.registry.message_type("rosgraph_msgs/Clock")
        clock = await there.robot.advertise("/clock", clock_type)
        chatter = await there.robot.advertise("/chatter", string_type(there))
        async with there.client() as client:
            # A connection announces its clock only once, so the clients connect again.
            await there.robot.set_param("/use_sim_time", True)
            assert await client.wait_closed() == 1012
        async with there.client() as client:
            assert "time" in (await client.wait("serverInfo"))["capabilities"]
            await until(lambda: clock.subscriber_count)
            clock.publish_raw([b"\5\0\0\0\7\0\0\0"])
            assert (await client.wait("time"))["time_ns"] == 5_000_000_007
            channel = await client.channel("/chatter")
            await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
            await until(lambda: chatter.subscriber_count)
            chatter.publish_raw([text(there, "x")])
            assert (await client.wait("messageData"))["time_ns"] == 5_000_000_007


async def test_assets_of_packages_are_read(tmp_path: Path) -> None:
    folder = tmp_path / "arm"
    folder.mkdir()
    (folder / "mesh.stl").write_bytes(b"solid")
    async with stage(find_packages=lambda: {"arm": folder}) as there, there.client() as client:
        await client.say("fetchAsset", uri="package://arm/mesh.stl", requestId=1)
        assert (await client.wait("fetchAssetResponse"))["data"] == b"solid"
        await client.say("fetchAsset", uri="package://arm/../../etc/passwd", requestId=2)
        answer = await client.wait("fetchAssetResponse", lambda each: each["request"] == 2)
        assert (answer["status"], answer["data"]) == (1, b"")


async def test_all_meshes_of_a_robot_come_however_large_and_many_they_are(tmp_path: Path) -> None:
    (tmp_path / "mesh.stl").write_bytes(bytes(6 << 20))
    limits = FoxgloveLimits(control_bytes=1 << 20, calls=2)
    async with (
        stage(FoxgloveSettings(port=0, limits=limits), find_packages=lambda: {"arm": tmp_path}) as there,
        there.client() as client,
    ):
        for number in range(5):
            await client.say("fetchAsset", uri="package://arm/mesh.stl", requestId=number)
        await until(lambda: len(client.of("fetchAssetResponse")) == 5)
        assert {len(each["data"]) for each in client.of("fetchAssetResponse")} == {6 << 20}


async def test_a_client_that_does_not_read_loses_messages_and_does_not_delay_others() -> None:
    limits = FoxgloveLimits(waiting_bytes=4 << 20)
    async with stage(FoxgloveSettings(port=0, limits=limits)) as there:
        publisher = await there.robot.advertise("/flood", string_type(there))
        async with there.client(max_queue=1) as slow, there.client() as quick:
            channel = await quick.channel("/flood")
            # What nobody reads fills the library's queue of one message and then the sockets.
            slow._reading.cancel()
            for client in (slow, quick):
                await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
            await until(lambda: len(there.gateway._clients) == 2 and publisher.subscriber_count)
            await until(lambda: all(each._subscriptions for each in there.gateway._clients))
            payload, count = text(there, "x" * 100_000), 200
            for _ in range(count):
                publisher.publish_raw([payload])
                await asyncio.sleep(0)
            await until(lambda: len(quick.of("messageData")) == count)
            dropped = [each._dropped.count for each in there.gateway._clients]
            assert sorted(dropped)[0] == 0
            assert sorted(dropped)[1] > 0
            waiting = max(each.line._data._waiting._bytes for each in there.gateway._clients)
            assert waiting <= limits.waiting_bytes
            slow.connection.transport.abort()
            slow._reading = asyncio.ensure_future(asyncio.sleep(0))


async def test_mistakes_are_reported_and_the_connection_stays() -> None:
    async with stage() as there, there.client() as client:
        for message in (
            "",
            "[]",
            "{",
            '{"op": 1}',
            '{"op": "subscribe"}',
            '{"op": "subscribe", "subscriptions": [1]}',
        ):
            await client.connection.send(message)
        for data in (b"", b"\x07", b"\x01\0", b"\x02\0\0\0\0\0\0\0\0\xff\xff\xff\xff"):
            await client.send_binary(data)
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": 12345}])
        nameless = {"id": 4, "topic": "", "encoding": "ros1", "schemaName": STRING}
        await client.say("advertise", channels=[nameless])
        await client.say("unadvertise", channelIds=[3])
        await client.publish(3, b"")
        await until(lambda: len(client.of("status")) == 14)
        assert all(each["level"] == 2 and "\n" not in each["message"] for each in client.of("status"))
        await client.say("getParameters", parameterNames=[], id="still here")
        await client.wait("parameterValues")


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
        await until(lambda: there.gateway.client_count == 0)
        async with there.client() as client:
            await client.wait("serverInfo")


async def test_requests_in_one_breath_are_bounded() -> None:
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


async def test_a_new_client_gets_the_list_of_channels_even_if_empty() -> None:
    nothing = NameFilter.of([], "test")
    settings = FoxgloveSettings(port=0, capabilities=("parameters",), topics=nothing)
    async with stage(settings) as there, there.client() as client:
        assert (await client.wait("advertise"))["channels"] == []
        assert "supportedEncodings" not in await client.wait("serverInfo")


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


async def test_the_address_is_one_that_can_be_typed() -> None:
    for host, shown in (
        ("localhost", "localhost"),
        ("127.0.0.1", "127.0.0.1"),
        ("0.0.0.0", socket.gethostname()),
    ):
        async with stage(FoxgloveSettings(host=host, port=0)) as there:
            assert there.gateway.url == f"ws://{shown}:{there.gateway.port}"


async def test_a_taken_port_is_reported_in_one_line() -> None:
    async with stage() as there:
        settings = FoxgloveSettings(port=there.gateway.port)
        graph = await there.network.join("/second")
        with pytest.raises(TransportOpenError, match=r"foxglove: port \d+ is already in use on localhost;"):
            await FoxgloveGateway(graph, there.store, settings).start()
        nowhere = FoxgloveSettings(host="203.0.113.1", port=0)
        with pytest.raises(TransportOpenError, match=r"not an address of this machine; 0\.0\.0\.0:0 listens"):
            await FoxgloveGateway(graph, there.store, nowhere).start()
        await graph.close()


async def test_nothing_is_left_when_a_gateway_closes() -> None:
    async with stage() as there:
        publisher = await there.robot.advertise("/chatter", string_type(there))
        async with there.client() as client:
            channel = await client.channel("/chatter")
            await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
            await client.say(
                "advertise", channels=[{"id": 1, "topic": "/cmd", "encoding": "ros1", "schemaName": STRING}]
            )
            await client.channel("/cmd")
            await there.gateway.close()
            assert await client.wait_closed() == 1001
        assert publisher.subscriber_count == 0
        assert "/cmd" not in (await there.robot.snapshot()).topics


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


async def test_a_client_asks_for_the_robot_s_time() -> None:
    async with stage() as there, there.client() as client:
        before_s = time.time()
        await client.say("askTime", id=7)
        answer = await client.wait("timeAnswer")
        assert answer["id"] == 7
        assert before_s - 1e-3 <= answer["sec"] + answer["nsec"] / 1e9 <= time.time() + 1e-3
        await client.say("askTime", id=-1)
        assert "unsigned" in (await client.wait("status"))["message"]
