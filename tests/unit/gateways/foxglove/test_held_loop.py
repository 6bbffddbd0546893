"""Messages of clients that take long: none may block the event loop, which also serves boards."""

from __future__ import annotations

import asyncio
import struct

import pytest

from loop_watch import TIMEOUT_S, CallbackWatch
from rostether.errors import RemoteProtocolError
from rostether.gateways.foxglove.client_messages import MAX_TEXT_MESSAGE_CHARACTERS, parse_text
from unit.gateways.foxglove.protocol_client import ProtocolClient, stage
from waiting import until

pytestmark = pytest.mark.slow


async def advertise(client: ProtocolClient, encoding: str, type_name: str, schema: str = "") -> None:
    channel = {"id": 1, "topic": "/flood", "encoding": encoding, "schemaName": type_name, "schema": schema}
    await client.say("advertise", channels=[channel | {"schemaEncoding": "ros1msg"}])


async def test_json_with_many_messages(monkeypatch: pytest.MonkeyPatch) -> None:
    async with stage() as there, there.client() as client:
        received: list[bytes] = []
        markers = there.store.registry.message_type("visualization_msgs/MarkerArray")
        await there.robot.subscribe("/flood", markers, received.extend)
        await advertise(client, "json", "visualization_msgs/MarkerArray")
        many = b'{"markers": [' + b"{}," * 20_000 + b"{}]}"
        watch = CallbackWatch(monkeypatch)
        # The first one waits for the topic, the others for the previous one.
        for payload in (many, many, b'{"markers": [{}]}', many):
            await client.publish(1, payload)
        await until(lambda: len(received) == 4)
        watch.check("20,000 markers")
        assert [struct.unpack_from("<I", each)[0] for each in received] == [20_001, 20_001, 1, 20_001]


async def test_a_message_with_many_strings(monkeypatch: pytest.MonkeyPatch) -> None:
    async with stage() as there, there.client() as client:
        await advertise(client, "ros1", "test_msgs/Strings", "string[] names")
        watch = CallbackWatch(monkeypatch)
        count = 1_000_000
        await client.publish(1, struct.pack("<I", count) + bytes(4 * count + 1))
        assert "1 byte more" in (await client.wait("status"))["message"]
        watch.check(f"{count} strings")


async def test_a_long_definition(monkeypatch: pytest.MonkeyPatch) -> None:
    async with stage() as there, there.client() as client:
        watch = CallbackWatch(monkeypatch)
        schema = "\n".join(f"string[] field_{number}" for number in range(4000))
        await advertise(client, "ros1", "test_msgs/Long", schema)
        await client.publish(1, b"short")
        assert "is not published" in (await client.wait("status"))["message"]
        watch.check("a definition with 4,000 fields")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"op": [' + ",".join(["9" * 4000] * 1000) + "]}", "more than 64 digits"),
        ('{"op": "' + "x" * MAX_TEXT_MESSAGE_CHARACTERS + '"}', "at most 4194304 characters"),
        ('{"op": "unadvertise", "channelIds": [' + "1," * 4096 + "1]}", "length <= 4096"),
    ],
    ids=["long integers", "a long text", "many items"],
)
def test_what_would_take_long_is_refused(text: str, reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=reason):
        parse_text(text)


async def test_a_client_that_leaves_during_a_conversion_ends_nothing_else() -> None:
    async with stage() as there:
        async with there.client() as client:
            await advertise(client, "json", "visualization_msgs/MarkerArray")
            for _ in range(3):
                await client.publish(1, b'{"markers": [' + b"{}," * 20_000 + b"{}]}")
        async with asyncio.timeout(TIMEOUT_S), there.client():
            pass
