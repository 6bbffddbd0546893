"""Boards over UDP, and senders of datagrams that are not boards."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator, Iterator
from typing import cast

import pytest

from rostether.bridge.peer_entry import BOARD_ENTRY, holds_answer, holds_frame
from rostether.bridge.settings import BridgeSettings
from rostether.bridge.supervisor import Supervisor
from rostether.graph.memory_network import MemoryNetwork
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.transports.address_parser import parse_address
from unit.bridge.doubles import RecordingReporter
from unit.bridge.nodes import STORE
from vectors.captures import load, names
from waiting import until

TIME_REQUEST = encode_frame(ids.TIME, bytes(8))


class Site:
    """A supervisor that listens on UDP, and a graph in memory."""

    def __init__(self) -> None:
        self.network = MemoryNetwork()
        self.reporter = RecordingReporter()
        self.supervisor = Supervisor(
            self.network.join, STORE, reporter=self.reporter, settings=BridgeSettings(grace_s=2.0)
        )

    @property
    def place(self) -> tuple[str, int]:
        return "127.0.0.1", int(self.supervisor.listening_on[0].rpartition(":")[2])

    def has_chatter(self) -> bool:
        return "/chatter" in self.network.snapshot().topics


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site()
    await site.supervisor.start([parse_address("udp://127.0.0.1:0")])
    yield site
    await site.supervisor.close()


@contextlib.contextmanager
def senders(count: int, place: tuple[str, int]) -> Iterator[list[socket.socket]]:
    with contextlib.ExitStack() as stack:
        sockets = [
            stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(count)
        ]
        for each in sockets:
            each.setblocking(False)
            each.connect(place)
        yield sockets


def received_bytes(sender: socket.socket) -> int:
    count = 0
    with contextlib.suppress(BlockingIOError):
        while True:
            count += len(sender.recv(65536))
    return count


class Board(asyncio.DatagramProtocol):
    """A board with the established firmware: it requests the time when it boots, then answers topic
    requests.
    """

    def __init__(self) -> None:
        # What a board sent after a topic request.
        self._answer = load("tcp_hello").of_device()[0].data

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.DatagramTransport, transport)
        self._transport.sendto(TIME_REQUEST)

    def datagram_received(self, data: bytes, addr: object) -> None:
        if BOARD_ENTRY.request in data:
            self._transport.sendto(self._answer)


@contextlib.asynccontextmanager
async def board(place: tuple[str, int]) -> AsyncIterator[None]:
    transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(Board, remote_addr=place)
    try:
        yield
    finally:
        transport.close()


@pytest.mark.parametrize("name", names())
def test_the_first_bytes_of_boards_have_a_frame(name: str) -> None:
    reported = b""
    for chunk in load(name).of_device()[:50]:
        reported += chunk.data
        if holds_frame(chunk.data) or holds_frame(reported):
            return
    pytest.fail("no frame in what the board said")


@pytest.mark.parametrize("data", [b"", b"x", b"\xff", b"\xff\xfe", BOARD_ENTRY.request, b"hello\r\n" * 200])
def test_bytes_that_are_no_frame_of_a_board(data: bytes) -> None:
    assert not holds_frame(data)


@pytest.mark.parametrize("name", names())
def test_the_bytes_after_a_request_have_an_answer(name: str) -> None:
    reported = b"".join(chunk.data for chunk in load(name).of_device()[:50])
    assert holds_answer(reported)


def test_a_time_request_is_not_an_answer() -> None:
    assert not holds_answer(TIME_REQUEST * 3)


async def test_a_board_that_only_asks_for_the_time_connects(site: Site) -> None:
    async with board(site.place):
        await until(site.has_chatter, "the board's topic")


async def test_forged_senders_use_no_connection_and_receive_nothing(site: Site) -> None:
    with senders(64, site.place) as forged:
        for each in forged:
            each.send(b"x")
        async with board(site.place):
            await until(site.has_chatter, "the board's topic")
        assert len(site.reporter.having("Connection from")) == 1
        assert sum(map(received_bytes, forged)) == 0


async def test_forged_frames_are_answered_with_no_more_and_give_way(site: Site) -> None:
    with senders(64, site.place) as forged:
        for each in forged:
            each.send(TIME_REQUEST)
        await until(lambda: len(site.supervisor.boards()) == 64, "the forged peers")
        await asyncio.sleep(0.6)
        async with board(site.place):
            await until(site.has_chatter, "the board's topic")
        assert sum(map(received_bytes, forged)) <= 64 * len(TIME_REQUEST)


async def test_forged_frames_of_one_address_are_never_answered_with_more(site: Site) -> None:
    with senders(1, site.place) as (forged,):
        sent = received = 0
        for _ in range(2):
            sent += forged.send(TIME_REQUEST)
            await asyncio.sleep(0.1)
        # The bridge repeats its topic request several times a second.
        for _ in range(20):
            await asyncio.sleep(0.1)
            received += received_bytes(forged)
        assert 0 < received <= sent
