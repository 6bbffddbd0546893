"""Topics of rosbridge clients: publish, subscribe, throttle, compress."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from rostether.gateways.rosbridge import client_publication
from rostether.gateways.rosbridge.png_packing import unpack_png
from unit.gateways.rosbridge.web_client import World, world
from unit.gateways.websocket.test_connection import frame, open_connection
from waiting import until

STRING = "std_msgs/String"


async def test_clients_receive_messages_of_others_under_their_own_topic_name(there: World) -> None:
    async with there.client() as talker, there.client() as listener:
        await listener.say("subscribe", topic="chatter", type=STRING)
        await listener.settled()
        await talker.say("advertise", topic="/chatter", type=STRING)
        await talker.say("publish", topic="/chatter", msg={"data": "hi"})
        assert await listener.receive() == {"op": "publish", "topic": "chatter", "msg": {"data": "hi"}}


async def test_first_words_wait_for_subscribers_that_are_on_their_way(there: World) -> None:
    received = asyncio.ensure_future(there.graph.wait_for_message("/chatter", STRING, timeout_s=60))
    async with there.client() as client:
        await until(lambda: "/chatter" in there.network.snapshot().topics)
        await client.say("advertise", topic="/chatter", type=STRING)
        await client.say("publish", topic="/chatter", msg={"data": "first"})
        assert (await received).data == "first"


async def test_messages_of_a_client_that_leaves_at_once_are_published(there: World) -> None:
    received = asyncio.ensure_future(there.graph.wait_for_message("/chatter", STRING, timeout_s=60))
    await until(lambda: "/chatter" in there.network.snapshot().topics)
    advertising = {"op": "advertise", "topic": "/chatter", "type": STRING}
    publishing = {"op": "publish", "topic": "/chatter", "msg": {"data": "last"}}
    reader, writer = await open_connection(there.server.port)
    await reader.readuntil(b"\r\n\r\n")
    messages = [frame(1, json.dumps(each).encode()) for each in (advertising, publishing)]
    writer.write(b"".join(messages) + frame(8, b""))
    assert (await received).data == "last"
    writer.close()


async def test_a_topic_that_exists_needs_no_advertising(there: World) -> None:
    messages = aiter(there.graph.messages("/chatter", STRING))
    received = asyncio.ensure_future(anext(messages))
    async with there.client() as client:
        await client.say("publish", topic="/nobody", msg={}, id="p1")
        status = await client.receive("status")
        assert status["level"] == "error"
        assert status["id"] == "p1"
        assert status["msg"] == "publish: /nobody has no type yet; advertise it first"
        await until(lambda: "/chatter" in there.network.snapshot().topics)
        await client.say("publish", topic="/chatter", msg={"data": "hi"})
        assert (await received).data == "hi"
    await messages.aclose()


async def test_a_topic_stays_until_each_object_of_a_page_has_unadvertised_it(there: World) -> None:
    async with there.client() as client:
        for each in ("a", "b"):
            await client.say("advertise", topic="/chatter", type=STRING, id=each)
        for each in ("a", "a"):
            await client.say("unadvertise", topic="/chatter", id=each)
        await client.say("publish", topic="/chatter", msg={"data": "by b"})
        assert await client.settled() == []
        await client.say("unadvertise", topic="/chatter", id="b")
        await client.say("unadvertise", topic="/chatter", id="b")
        assert "does not advertise /chatter" in (await client.receive("status"))["msg"]


async def test_a_page_that_advertises_for_each_message_is_bounded(
    there: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(client_publication, "MAX_IDS", 2)
    async with there.client() as client:
        for each in ("a", "b", "c"):
            await client.say("advertise", topic="/chatter", type=STRING, id=each)
        for each in ("a", "b", "c"):
            await client.say("unadvertise", topic="/chatter", id=each)
        await client.say("unadvertise", topic="/chatter", id="a")
        assert "does not advertise /chatter" in (await client.receive("status"))["msg"]


async def test_unsubscribing_ends_it_and_ids_keep_others(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", id="a")
        await client.say("subscribe", topic="/chatter", id="b")
        await client.settled()
        publisher.publish(data="both")
        assert (await client.receive("publish"))["msg"] == {"data": "both"}
        await client.say("unsubscribe", topic="/chatter", id="a")
        await client.settled()
        publisher.publish(data="one")
        assert (await client.receive("publish"))["msg"] == {"data": "one"}
        await client.say("unsubscribe", topic="/chatter", id="b")
        await client.settled()
        assert publisher.subscriber_count == 0
        await client.say("unsubscribe", topic="/chatter")
        assert "is not subscribed to /chatter" in (await client.receive("status"))["msg"]


async def test_a_subscription_of_the_wrong_type_is_reported_once_and_gets_nothing(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", type="std_msgs/Int32")
        await client.settled()
        publisher.publish(data="a")
        publisher.publish(data="b")
        assert (await client.receive("status"))["msg"] == (
            "subscribe: /chatter: its type is std_msgs/String, not std_msgs/Int32"
        )
        assert await client.settled() == []


@pytest.mark.parametrize("name", ["std_msgs/String", "std_msgs/msg/String"])
async def test_types_may_be_written_as_either_ros_does(there: World, name: str) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", type=name)
        await client.say("advertise", topic="/other", type=name)
        assert await client.settled() == []
        publisher.publish(data="a")
        await client.receive("publish")


async def test_compressions(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", compression="png")
        await client.settled()
        publisher.publish(data="hi")
        png = await client.receive("png")
        assert json.loads(unpack_png(png["data"], 1000)) == {
            "op": "publish",
            "topic": "/chatter",
            "msg": {"data": "hi"},
        }
        cbor2 = pytest.importorskip("cbor2")
        await client.say("subscribe", topic="/chatter", compression="cbor", id="stronger")
        await client.settled()
        publisher.publish(data="hi")
        assert cbor2.loads(await client.connection.recv())["msg"] == {"data": "hi"}
        await client.say("subscribe", topic="/chatter", compression="cbor-raw", id="strongest")
        await client.settled()
        publisher.publish(data="hi")
        raw = cbor2.loads(await client.connection.recv())["msg"]
        assert raw["bytes"] == b"\x02\0\0\0hi"
        assert raw["secs"] > 0
        await client.say("subscribe", topic="/other", compression="zip")
        assert (
            'compression must be one of none, png, cbor, cbor-raw, got "zip"'
            in (await client.receive())["msg"]
        )


async def test_a_topic_of_others_keeps_its_type(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", "std_msgs/String")
    async with there.client() as client:
        await client.say("advertise", topic="/chatter", type="std_msgs/Int32", id="wrong")
        status = await client.receive("status")
        assert status["msg"] == "advertise: /chatter has the type std_msgs/String; use it"
        assert status["id"] == "wrong"
        await client.say("advertise", topic="/chatter", type="std_msgs/msg/String")
        assert await client.settled() == []
        await client.say("unadvertise", topic="/chatter")
        await client.settled()
        await publisher.close()
        await client.say("advertise", topic="/chatter", type="std_msgs/Int32")
        assert await client.settled() == []


async def test_a_topic_latches_from_when_it_was_asked_to(there: World) -> None:
    async with there.client() as client, there.client() as late:
        await client.say("advertise", topic="/plan", type="std_msgs/String")
        await client.say("advertise", topic="/plan", type="std_msgs/String", latch=True)
        await client.say("advertise", topic="/plan", type="std_msgs/String")
        await client.say("publish", topic="/plan", msg={"data": "kept"})
        await client.settled()
        await late.say("subscribe", topic="/plan")
        assert (await late.receive("publish"))["msg"] == {"data": "kept"}


async def test_a_slow_reader_loses_the_oldest_with_a_report_and_does_not_delay_others(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as slow, there.client() as fast:
        for client in (slow, fast):
            await client.say("subscribe", topic="/chatter", type=STRING, queue_length=5)
            await client.settled()
        slow.connection.transport.pause_reading()
        text = "x" * 100_000
        for number in range(300):
            publisher.publish(data=f"{number} {text}")
            received = (await fast.receive("publish"))["msg"]["data"]
            assert received.startswith(f"{number} ")
        slow.connection.transport.resume_reading()
        numbers: list[int] = []
        statuses: list[dict[str, Any]] = []
        while not statuses or 299 not in numbers:
            message = await slow.receive()
            if message["op"] == "publish":
                numbers.append(int(message["msg"]["data"].split()[0]))
            else:
                statuses.append(message)
        assert numbers == sorted(numbers)
        assert 5 <= len(numbers) < 300
        assert numbers[-1] == 299
        assert statuses[0]["level"] == "warning"
        assert "/chatter is too fast for this client" in statuses[0]["msg"]
        assert "too slowly" in there.warnings[0]


async def test_throttled_topics_come_at_their_rate(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", throttle_rate=60_000)
        await client.settled()
        for number in range(20):
            publisher.publish(data=str(number))
        assert (await client.receive("publish"))["msg"]["data"] == "0"
        assert await client.settled() == []
        await client.say("subscribe", topic="/chatter", throttle_rate=0, id="all")
        await client.settled()
        publisher.publish(data="now")
        assert (await client.receive("publish"))["msg"]["data"] == "now"


async def test_a_late_client_receives_latched_messages(there: World) -> None:
    async with there.client() as talker, there.client() as first, there.client() as late:
        await talker.say("advertise", topic="/map", type=STRING, latch=True)
        await talker.say("publish", topic="/map", msg={"data": "here"})
        for client in (first, late):
            await client.say("subscribe", topic="/map", type=STRING)
            assert (await client.receive("publish"))["msg"] == {"data": "here"}


async def test_a_topic_lingers_when_its_client_has_left_and_ends_with_the_server() -> None:
    async with world() as there:
        async with there.client() as client:
            await client.say("advertise", topic="/chatter", type=STRING)
            await client.settled()
        await there.wait_until_all_left()
        assert "/chatter" in there.network.snapshot().topics
        await there.server.close()
        assert "/chatter" not in there.network.snapshot().topics


async def test_a_page_that_was_loaded_again_may_publish_another_type(there: World) -> None:
    async with there.client() as client, there.client() as other:
        await client.say("advertise", topic="/chatter", type=STRING)
        await client.settled()
        await other.say("advertise", topic="/chatter", type="std_msgs/Int32")
        assert "publishes /chatter as std_msgs/String," in (await other.receive("status"))["msg"]
        await client.say("unadvertise", topic="/chatter")
        await client.settled()
        await other.say("advertise", topic="/chatter", type="std_msgs/Int32")
        assert await other.settled() == []
        assert there.network.snapshot().topics["/chatter"].type == "std_msgs/Int32"


def test_first_words_are_bounded() -> None:
    assert client_publication.MAX_FIRST_BYTES <= 16 << 20
