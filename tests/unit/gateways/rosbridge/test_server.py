from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from dataclasses import replace
from typing import Any

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from rostether.errors import ServiceCallError, TransportOpenError
from rostether.gateways.rosbridge import client_services, publication, server, session
from rostether.gateways.rosbridge.png_packing import pack_png, unpack_png
from rostether.gateways.rosbridge.server import RosbridgeServer
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.graph.memory_network import MemoryNetwork
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from unit.gateways.rosbridge.web_client import World, world
from unit.gateways.websocket.test_connection import frame, open_connection
from waiting import until

STRING = "std_msgs/String"
SETTINGS = RosbridgeSettings(host="127.0.0.1", port=0)


@pytest.fixture
async def there() -> AsyncIterator[World]:
    async with world() as made:
        yield made


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
            "compression must be one of none, png, cbor, cbor-raw, got 'zip'"
            in (await client.receive())["msg"]
        )


async def test_fragments_both_ways_and_pictures_in(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", STRING)
    async with there.client() as client:
        await client.say("subscribe", topic="/chatter", fragment_size=50)
        await client.settled()
        publisher.publish(data="x" * 100)
        pieces = [await client.receive("fragment")]
        while len(pieces) < pieces[0]["total"]:
            pieces.append(await client.receive("fragment"))
        whole = json.loads("".join(piece["data"] for piece in pieces))
        assert whole["msg"]["data"] == "x" * 100
        await client.say("unsubscribe", topic="/chatter")
        text = json.dumps({"op": "call_service", "service": "/settled", "id": "in pieces"})
        for number in (1, 0):
            await client.say(
                "fragment",
                id="f",
                num=number,
                total=2,
                data=text[number * 20 :][: 20 if not number else None],
            )
        assert (await client.receive("service_response"))["id"] == "in pieces"
        await client.connection.send(pack_png(text.replace("pieces", "a picture")))
        assert (await client.receive("service_response"))["id"] == "in a picture"


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
            ({"data": "yes"}, "std_srvs/SetBoolRequest needs a bool for field data, got 'yes'"),
            ([True, 1], "call_service: std_srvs/SetBoolRequest has 1 fields, args 2 values"),
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


async def test_a_call_that_takes_long_holds_up_nothing_and_ends_in_time(there: World) -> None:
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
        assert answer["values"] == "service /hang did not answer within 0.05 s"
        await called.wait()
    # Hanging up while a call is under way leaves nothing behind.
    await until(lambda: there.server.client_count == 0)


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
        assert refused["values"] == "this client has 2 pending calls; /hang is not called"
        await client.say("publish", topic="/nobody", msg={})
        assert "advertise it first" in (await client.receive("status"))["msg"]


async def test_a_topic_of_others_keeps_its_type(there: World) -> None:
    publisher = await there.graph.publisher("/chatter", "std_msgs/String")
    async with there.client() as client:
        await client.say("advertise", topic="/chatter", type="std_msgs/Int32", id="wrong")
        status = await client.receive("status")
        assert status["msg"] == "advertise: /chatter is std_msgs/String, not std_msgs/Int32"
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
        assert "bytes of pending calls; /hang is not called" in refused["values"]
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
        assert "no call of /add has the id 'made up'" in (await client.receive("status"))["msg"]
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


@pytest.mark.parametrize(
    ("output", "reported"),
    [
        ("garbage", "this is not JSON"),
        (b"\xff\xfe", "this is not JSON"),
        ("[]", "a message must be a JSON object with an op"),
        ('{"op": "dance"}', "unknown op 'dance'; known: advertise"),
        ('{"op": "publish"}', "publish: field 'topic' must be a string, got nothing"),
        ('{"op": "publish", "topic": ["/a"]}', "publish: field 'topic' must be a string"),
        ('{"op": "subscribe", "topic": "not a name"}', "not a name"),
        ('{"op": "subscribe", "topic": "\\ud800"}', "name"),
        ('{"op": "advertise", "topic": "/a", "type": "no_msgs/No"}', "no package 'no_msgs' is known"),
        ('{"op": "advertise", "topic": "/a", "type": "../../etc/passwd"}', "passwd"),
        ('{"op": "advertise", "topic": "/a", "type": ""}', ""),
        ('{"op": "subscribe", "topic": "/a", "throttle_rate": "fast"}', "'throttle_rate' must be a number"),
        ('{"op": "unadvertise", "topic": "\\ud800 \\u001b[2J"}', r"does not advertise \ud800 \u001b[2J"),
        ('{"op": "dance\\ud800"}', "unknown op"),
        (
            '{"op": "set_level", "level": "loud"}',
            "level must be one of none, error, warning, info, got 'loud'",
        ),
        ('{"op": "unadvertise", "topic": "/a"}', "does not advertise /a"),
        ('{"op": "advertise_service", "service": "/a", "type": "std_srvs/No"}', "has no service 'No'"),
        ('{"op": "unadvertise_service", "service": "/a"}', "this client does not offer /a"),
        ('{"op": "service_response", "service": "/a"}', "this client does not offer /a"),
        ('{"op": "fragment", "id": 1, "num": 5, "total": 2, "data": ""}', "fragment: num counts from 0"),
        ('{"op": "fragment"}', "fragment: "),
        ('{"op": "png", "data": "nonsense"}', "png: "),
        ('{"op": "png"}', "png: field 'data' must be a string, got nothing"),
    ],
)
async def test_every_mistake_is_reported_in_one_line_and_the_client_stays(
    there: World, output: str | bytes, reported: str
) -> None:
    async with there.client() as client:
        await client.connection.send(output)
        status = await client.receive("status")
        assert status["level"] == "error"
        assert reported in status["msg"]
        assert "\n" not in status["msg"]
        assert await client.settled() == []
        assert there.warnings
        assert all(line.isprintable() for line in there.warnings)


async def test_messages_packed_into_each_other_without_end_are_refused(there: World) -> None:
    async with there.client() as client:
        text = json.dumps({"op": "status"})
        for _ in range(6):
            text = pack_png(text)
        await client.connection.send(text)
        assert "packed into too many others" in (await client.receive("status"))["msg"]


async def test_statuses_are_as_loud_as_was_set(there: World) -> None:
    async with there.client() as client:
        await client.say("set_level", level="none")
        await client.connection.send("garbage")
        assert await client.settled() == []
        await client.say("set_level", level="error")
        await client.connection.send("garbage")
        assert len(await client.settled()) == 1


async def test_the_log_is_not_flooded_by_mistakes(there: World) -> None:
    async with there.client() as client:
        for number in range(50):
            await client.connection.send(f"garbage {number // 2}")
        assert len(await client.settled()) == 50
    assert len(set(there.warnings)) == len(there.warnings)
    assert len(there.warnings) == session.MAX_LOGGED
    assert there.warnings[-1].endswith("further errors are sent only to the client")


async def test_text_that_is_not_utf8_ends_only_that_client(there: World) -> None:
    async with there.client() as other, there.client() as client:
        # A text frame, masked with zeros, that holds no UTF-8.
        client.connection.transport.write(b"\x81\x82\0\0\0\0\xff\xfe")
        with pytest.raises(ConnectionClosed) as caught:
            await client.receive()
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1007
        assert await other.settled() == []


async def test_messages_that_are_too_large_end_that_client_alone() -> None:
    settings = replace(SETTINGS, max_message_bytes=1000)
    async with world(settings) as there, there.client() as other, there.client() as client:
        await client.say("publish", topic="/a", msg={"data": "x" * 2000})
        with pytest.raises(ConnectionClosed) as caught:
            await client.receive()
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1009
        for number in range(3):
            await other.say("fragment", id="f", num=number, total=9, data="x" * 500)
        assert "the message has more than 1000 bytes" in (await other.settled())[0]["msg"]


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
        await until(lambda: there.server.client_count == 0)
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


async def test_pages_of_other_sites_are_refused_with_a_hint(there: World) -> None:
    with pytest.raises(InvalidStatus) as caught:
        async with there.client(origin="http://evil.example"):
            pass
    assert caught.value.response.status_code == 403
    body = bytes(caught.value.response.body or b"").decode()
    assert body == (
        "pages of http://evil.example may not connect; allow them with --origin http://evil.example\n"
    )
    async with there.client(origin="http://localhost:8000") as client:
        assert await client.settled() == []


async def test_a_token_must_be_given() -> None:
    async with world(replace(SETTINGS, token="abc")) as there:
        async with there.client("/?token=abc") as client:
            assert await client.settled() == []
        async with there.client() as client:
            await client.say("auth", token="abc")
            assert await client.settled() == []
        async with there.client("/?token=wrong") as client:
            await client.say("subscribe", topic="/chatter")
            assert "this server requires a token" in (await client.receive("status"))["msg"]
            with pytest.raises(ConnectionClosed) as caught:
                await client.receive()
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == 1008
        assert "/chatter" not in there.network.snapshot().topics


async def test_names_outside_of_the_globs_are_refused() -> None:
    settings = replace(SETTINGS, topics_glob=("/open/*",), services_glob=("/open/*",))
    async with world(settings) as there, there.client() as client:
        await client.say("subscribe", topic="/open/a", type=STRING)
        await client.say("advertise", topic="/open/a", type=STRING)
        await client.say("call_service", service="/secret", id="c")
        assert "not among the services" in (await client.receive("service_response"))["values"]
        refused: list[tuple[str, dict[str, Any]]] = [
            ("subscribe", {"topic": "/secret"}),
            ("advertise", {"topic": "/secret", "type": STRING}),
            ("publish", {"topic": "secret", "msg": {}}),
            ("advertise_service", {"service": "/secret", "type": "std_srvs/Trigger"}),
        ]
        for op, fields in refused:
            await client.say(op, **fields)
            status = await client.receive("status")
            assert status["level"] == "error"


async def test_clients_are_counted_and_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "MAX_CLIENTS", 1)
    async with world(SETTINGS) as there:
        await clients_are_counted_and_bounded(there)


async def clients_are_counted_and_bounded(there: World) -> None:
    counts = aiter(there.graph.messages("/client_count"))
    assert (await anext(counts)).data == 0
    async with there.client():
        assert (await anext(counts)).data == 1
        with pytest.raises(InvalidStatus) as caught:
            async with there.client():
                pass
        assert caught.value.response.status_code == 503
    assert (await anext(counts)).data == 0
    await counts.aclose()


async def test_the_oldest_silent_connection_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "MAX_CLIENTS", 2)
    monkeypatch.setattr(server, "MAX_GREETING", 1)
    async with world(SETTINGS) as there:
        silent = [await asyncio.open_connection("127.0.0.1", there.server.port) for _ in range(4)]
        with contextlib.suppress(ConnectionError):
            assert await silent[0][0].read() == b""
        assert not any(reader.at_eof() for reader, _ in silent[1:])
        for _, writer in silent:
            writer.close()


async def test_many_clients_come_and_go_and_nothing_stays(there: World) -> None:
    async def visit(number: int) -> None:
        async with there.client() as client:
            await client.say("subscribe", topic="/chatter", type=STRING)
            await client.say("advertise", topic="/chatter", type=STRING)
            if number % 2:
                client.connection.transport.abort()

    for start in range(0, 100, 20):
        await asyncio.gather(*(visit(number) for number in range(start, start + 20)))
    await until(lambda: there.server.client_count == 0)
    assert "/rosbridge_websocket" not in there.network.snapshot().topics["/chatter"].subscribers


async def test_the_node_that_is_shut_down_ends_the_server(there: World) -> None:
    async with there.client() as client:
        graph = there.server._context.graph  # the node is the server's alone
        await graph.close()
        await there.server.wait_ended()
        with pytest.raises(ConnectionClosed):
            await client.receive()
    assert "its node was shut down" in there.warnings[0]


async def test_a_port_that_is_taken_is_reported_with_what_to_do(there: World) -> None:
    network = MemoryNetwork()
    graph = await network.join("/second")
    second = RosbridgeServer(
        graph, TypeStore(Registry()), RosbridgeSettings(host="127.0.0.1", port=there.server.port)
    )
    with pytest.raises(
        TransportOpenError, match=r"port \d+ is already in use on 127.0.0.1; stop the program"
    ):
        await second.start()
    await second.close()
    third = RosbridgeServer(graph, TypeStore(Registry()), RosbridgeSettings(host="203.0.113.1", port=0))
    with pytest.raises(TransportOpenError, match=r"203.0.113.1 is not an address of this machine"):
        await third.start()
    await graph.close()


async def test_localhost_is_both_loopback_addresses() -> None:
    async with world(RosbridgeSettings(port=0)) as there:
        assert there.server.uri == f"ws://localhost:{there.server.port}"
        async with connect(there.server.uri):
            pass
        assert set(there.server._server.hosts) in ({"127.0.0.1", "::1"}, {"127.0.0.1"})


def test_first_words_are_bounded() -> None:
    assert publication.MAX_FIRST_BYTES <= 16 << 20
