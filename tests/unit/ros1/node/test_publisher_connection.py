"""The turns in which a connection passes on a publisher's messages, and its pauses."""

import asyncio
from collections.abc import Callable, Sequence

from rostether.ros1.node.publisher_connection import TURN_MESSAGES, PublisherConnection
from rostether.ros1.tcpros_connection import ConnectionRecord
from rostether.tcpros.message_framing import MAX_MESSAGE_BYTES, encode_messages
from unit.ros1.node.raw_peers import until

MANY = [b"%d" % number for number in range(3 * TURN_MESSAGES)]


class FakeTransport(asyncio.Transport):
    """Records in `reads` whether it reads."""

    def __init__(self) -> None:
        super().__init__()
        self.reads = True

    def pause_reading(self) -> None:
        self.reads = False

    def resume_reading(self) -> None:
        self.reads = True

    def is_closing(self) -> bool:
        return False


def connection_to(
    transport: asyncio.Transport, receive: Callable[[Sequence[bytes]], None]
) -> PublisherConnection:
    record = ConnectionRecord(transport, peer="http://talker:1/", topic="/chat", direction="i")
    return PublisherConnection(transport, record, receive, MAX_MESSAGE_BYTES)


async def test_a_receiver_that_pauses_and_resumes_in_its_callback_gets_messages_in_order() -> None:
    received: list[bytes] = []

    def receive(payloads: Sequence[bytes]) -> None:
        connection.pause()
        connection.resume()
        received.extend(payloads)

    transport = FakeTransport()
    connection = connection_to(transport, receive)
    connection.data_received(encode_messages(MANY))
    await until(lambda: len(received) == len(MANY))
    assert received == MANY
    await until(lambda: transport.reads)


async def test_a_pause_within_a_turn_does_not_make_turns_longer() -> None:
    received: list[bytes] = []
    connection = connection_to(FakeTransport(), received.extend)
    connection.data_received(encode_messages(MANY))
    connection.pause()
    connection.resume()
    await asyncio.sleep(0)
    assert len(received) <= 2 * TURN_MESSAGES


async def test_data_held_during_a_pause_arrives_although_the_connection_has_ended() -> None:
    received: list[bytes] = []
    connection = connection_to(FakeTransport(), received.extend)
    connection.pause()
    connection.data_received(encode_messages([b"last"]))
    connection.connection_lost(None)
    assert not connection.lost.is_set()
    connection.resume()
    async with asyncio.timeout(5):
        await connection.lost.wait()
    assert received == [b"last"]
