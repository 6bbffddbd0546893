"""The server's answers to wrong messages, and their effects on others."""

from __future__ import annotations

import json

import pytest
from msgspec.structs import replace
from websockets.exceptions import ConnectionClosed

from rostether.gateways.rosbridge import session
from rostether.gateways.rosbridge.png_packing import pack_png
from rostether.gateways.rosbridge.settings import RosbridgeLimits, RosbridgeSettings
from unit.gateways.rosbridge.web_client import World, world

SETTINGS = RosbridgeSettings(host="127.0.0.1", port=0)


@pytest.mark.parametrize(
    ("output", "reported"),
    [
        ("garbage", "this is not JSON"),
        (b"\xff\xfe", "this is not JSON"),
        ("[]", "a message must be a JSON object with an op"),
        ('{"op": "dance"}', 'unknown op "dance"; known: advertise'),
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
            'level must be one of none, error, warning, info, got "loud"',
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
        assert "may be packed at most 3 times" in (await client.receive("status"))["msg"]


async def test_statuses_follow_the_level_that_was_set(there: World) -> None:
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
        # A text frame, masked with zeros, whose text is not valid UTF-8.
        client.connection.transport.write(b"\x81\x82\0\0\0\0\xff\xfe")
        with pytest.raises(ConnectionClosed) as caught:
            await client.receive()
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1007
        assert await other.settled() == []


async def test_messages_that_are_too_large_end_that_client_alone() -> None:
    settings = replace(SETTINGS, limits=RosbridgeLimits(message_bytes=1000))
    async with world(settings) as there, there.client() as other, there.client() as client:
        await client.say("publish", topic="/a", msg={"data": "x" * 2000})
        with pytest.raises(ConnectionClosed) as caught:
            await client.receive()
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1009
        for number in range(3):
            await other.say("fragment", id="f", num=number, total=9, data="x" * 500)
        assert "a message may have at most 1000 bytes" in (await other.settled())[0]["msg"]
