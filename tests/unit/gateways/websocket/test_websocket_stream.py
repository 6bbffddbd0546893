from __future__ import annotations

import asyncio
from typing import cast

from rostether.gateways.websocket.connection import Connection
from rostether.gateways.websocket.websocket_stream import MAX_WAITING, WebSocketStream


class FakeConnection:
    """Records a stream's calls of its connection."""

    def __init__(self) -> None:
        self.calls: list[object] = []
        self.has_room = asyncio.Event()

    def pause_reading(self) -> None:
        self.calls.append("pause")

    def resume_reading(self) -> None:
        self.calls.append("resume")

    def send(self, *messages: str | bytes) -> None:
        self.calls.append(messages)


def stream() -> tuple[FakeConnection, WebSocketStream]:
    connection = FakeConnection()
    return connection, WebSocketStream(cast("Connection", connection))


async def test_messages_come_in_their_order_up_to_the_end() -> None:
    _, messages = stream()
    collecting = asyncio.ensure_future(anext_all(messages))
    await asyncio.sleep(0)
    messages.received("a")
    messages.received(b"b")
    messages.closed()
    assert await collecting == ["a", b"b"]
    assert await messages.receive() is None


async def anext_all(messages: WebSocketStream) -> list[str | bytes]:
    return [each async for each in messages]


async def test_a_client_that_sends_faster_than_it_is_served_is_not_read() -> None:
    connection, messages = stream()
    for number in range(MAX_WAITING + 5):
        messages.received(str(number))
    assert connection.calls == ["pause"]
    for _ in range(MAX_WAITING + 4):
        await messages.receive()
    assert connection.calls == ["pause"]
    await messages.receive()
    assert connection.calls == ["pause", "resume"]


async def test_sending_waits_until_the_client_has_read() -> None:
    connection, messages = stream()
    sending = asyncio.ensure_future(messages.send("a", b"b"))
    await asyncio.sleep(0)
    assert connection.calls == [("a", b"b")]
    assert not sending.done()
    connection.has_room.set()
    await sending
