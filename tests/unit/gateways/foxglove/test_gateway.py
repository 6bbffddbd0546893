"""A gateway and its clients, over real sockets."""

from __future__ import annotations

import asyncio
import socket
import time
from pathlib import Path

import pytest

from rostether.errors import TransportOpenError
from rostether.gateways.foxglove.gateway import FoxgloveGateway
from rostether.gateways.foxglove.settings import FoxgloveLimits, FoxgloveSettings, NameFilter
from unit.gateways.foxglove.protocol_client import STRING, stage, string_type, text
from waiting import until


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
        # A float stays a float, because the type of a parameter is fixed on ROS 2.
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


async def test_a_client_that_does_not_read_loses_messages_and_does_not_delay_others() -> None:
    limits = FoxgloveLimits(waiting_bytes=4 << 20)
    async with stage(FoxgloveSettings(port=0, limits=limits)) as there:
        publisher = await there.robot.advertise("/flood", string_type(there))
        async with there.client(max_queue=1) as slow, there.client() as quick:
            channel = await quick.channel("/flood")
            # Unread messages fill the library's queue of one message and then the sockets.
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
            dropped = [each.sender._dropped.count for each in there.gateway._clients]
            assert sorted(dropped)[0] == 0
            assert sorted(dropped)[1] > 0
            waiting = max(each.sender.data._waiting._bytes for each in there.gateway._clients)
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


async def test_a_new_client_gets_the_list_of_channels_even_if_empty() -> None:
    nothing = NameFilter.of([], "test")
    settings = FoxgloveSettings(port=0, capabilities=("parameters",), topics=nothing)
    async with stage(settings) as there, there.client() as client:
        assert (await client.wait("advertise"))["channels"] == []
        assert "supportedEncodings" not in await client.wait("serverInfo")


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


async def test_a_client_asks_for_the_robot_s_time() -> None:
    async with stage() as there, there.client() as client:
        before_s = time.time()
        await client.say("askTime", id=7)
        answer = await client.wait("timeAnswer")
        assert answer["id"] == 7
        assert before_s - 1e-3 <= answer["sec"] + answer["nsec"] / 1e9 <= time.time() + 1e-3
        await client.say("askTime", id=-1)
        assert "expected integer >= 0" in (await client.wait("status"))["message"]
