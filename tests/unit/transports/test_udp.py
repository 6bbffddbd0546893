from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from rostether.errors import TransportClosedError, TransportOpenError
from rostether.transports.address import UdpAddress
from rostether.transports.transport import Transport
from rostether.transports.udp import MAX_DATAGRAM_BYTES, UdpListener, connect_udp, split_datagrams
from unit.transports.recorder import Arrivals, Recorder
from unit.transports.strangers import trust_nobody
from waiting import until


class Clock:
    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def port_of(listener: UdpListener) -> int:
    return int(listener.address.rpartition(":")[2])


@asynccontextmanager
async def listening(
    *, allow: tuple[str, ...] = (), max_peers: int = 8, clock: Clock | None = None
) -> AsyncIterator[tuple[UdpListener, Arrivals]]:
    arrivals = Arrivals()
    address = UdpAddress("127.0.0.1", 0, allow=allow)
    listener = await UdpListener.start(address, arrivals, max_peers=max_peers)
    if clock is not None:
        listener.peers.now_s = clock
    try:
        yield listener, arrivals
    finally:
        await listener.close()


@asynccontextmanager
async def connected_to(listener: UdpListener) -> AsyncIterator[tuple[Transport, Recorder]]:
    transport = await connect_udp(UdpAddress("127.0.0.1", port_of(listener), connect=True))
    recorder = Recorder()
    transport.start(recorder)
    try:
        yield transport, recorder
    finally:
        transport.close()
        await transport.wait_closed()


async def test_each_peer_has_a_separate_transport() -> None:
    async with (
        listening() as (listener, arrivals),
        connected_to(listener) as (left, left_seen),
        connected_to(listener) as (right, right_seen),
    ):
        left.write(b"left")
        host_left, left_data = await arrivals.next_started()
        right.write(b"right")
        host_right, right_data = await arrivals.next_started()
        await left_data.until_received(b"left")
        await right_data.until_received(b"right")
        host_left.write(b"to left")
        host_right.write(b"to right")
        await left_seen.until_received(b"to left")
        await right_seen.until_received(b"to right")
        assert host_left.peer != host_right.peer
        assert host_left.peer.startswith("udp 127.0.0.1:")
        assert not host_left.can_pause


async def test_long_writes_become_datagrams_that_no_network_fragments() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as raw:
        raw.bind(("127.0.0.1", 0))
        raw.setblocking(False)
        board = await connect_udp(UdpAddress("127.0.0.1", raw.getsockname()[1], connect=True))
        data = bytes(range(256)) * 12
        board.write(memoryview(data))
        loop = asyncio.get_running_loop()
        datagrams = [await asyncio.wait_for(loop.sock_recv(raw, 65536), 60) for _ in range(3)]
        assert [len(datagram) for datagram in datagrams] == [MAX_DATAGRAM_BYTES, MAX_DATAGRAM_BYTES, 272]
        assert b"".join(datagrams) == data
        board.close()
        await board.wait_closed()


@pytest.mark.parametrize("length", [0, 1, MAX_DATAGRAM_BYTES, MAX_DATAGRAM_BYTES + 1])
def test_split_into_as_few_datagrams_as_possible(length: int) -> None:
    pieces = list(split_datagrams(bytes(length)))
    assert b"".join(pieces) == bytes(length)
    assert len(pieces) == -(-length // MAX_DATAGRAM_BYTES)


async def test_silent_peers_expire_and_return_as_new_ones() -> None:
    clock = Clock()
    async with listening(clock=clock) as (listener, arrivals), connected_to(listener) as (board, _):
        board.write(b"a")
        host, seen = await arrivals.next_started()
        clock.now_s = 29.0
        listener.peers.expire()
        assert not seen.losses
        clock.now_s = 30.0
        listener.peers.expire()
        error = await seen.until_lost()
        assert isinstance(error, TransportClosedError)
        assert "silent for 30 s" in str(error)
        assert len(listener.peers) == 0
        await host.wait_closed()
        board.write(b"b")
        _, seen_again = await arrivals.next_started()
        await seen_again.until_received(b"b")


async def test_new_peers_beyond_the_limit_wait_for_a_silent_one_to_expire() -> None:
    clock = Clock()
    async with (
        listening(max_peers=1, clock=clock) as (listener, arrivals),
        connected_to(listener) as (first, _),
        connected_to(listener) as (second, _),
    ):
        first.write(b"first")
        await arrivals.next_started()
        second.write(b"refused")
        await until(lambda: listener.peers.refusals.count == 1)
        clock.now_s = 31.0
        second.write(b"second")
        _, seen = await arrivals.next_started()
        await seen.until_received(b"second")


async def test_a_peer_outside_the_allowed_networks_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    trust_nobody(monkeypatch)
    async with (
        listening(allow=("10.0.0.0/8",)) as (listener, arrivals),
        connected_to(listener) as (board, _),
    ):
        board.write(b"x")
        await until(lambda: listener.peers.refusals.count == 1)
        assert arrivals.count == 0


async def test_bytes_wait_for_start_and_for_resume_up_to_a_limit() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, _):
        board.write(b"early ")
        host = await arrivals.next()
        seen = Recorder()
        host.start(seen)
        await seen.until_received(b"early ")
        host.pause_reading()
        for _ in range(100):
            board.write(bytes(1400))
            await asyncio.sleep(0)
        received = len(seen.data)
        host.resume_reading()
        await seen.until(lambda seen: len(seen.data) > received)
        assert len(seen.data) <= 6 + 64 * 1024


async def test_a_closed_peer_is_new_when_it_sends_again() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, _):
        board.write(b"1")
        host, seen = await arrivals.next_started()
        await seen.until_received(b"1")
        host.close()
        host.write(b"too late")
        assert await seen.until_lost() is None
        board.write(b"2")
        _, seen_again = await arrivals.next_started()
        await seen_again.until_received(b"2")


async def test_closing_the_listener_ends_its_peers() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, _):
        board.write(b"1")
        _, seen = await arrivals.next_started()
        await listener.close()
        assert await seen.until_lost() is None
        await listener.close()


async def test_a_board_that_is_not_there_yet_ends_nothing() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as raw:
        raw.bind(("127.0.0.1", 0))
        port = raw.getsockname()[1]
    board = await connect_udp(UdpAddress("127.0.0.1", port, connect=True))
    seen = Recorder()
    board.start(seen)
    for _ in range(5):
        board.write(b"hello")
        await asyncio.sleep(0.005)
    assert not seen.losses
    board.close()
    await board.wait_closed()


async def test_send_from_the_port_a_board_expects() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        free_port = probe.getsockname()[1]
    async with listening() as (listener, arrivals):
        address = UdpAddress("127.0.0.1", port_of(listener), connect=True, bind=free_port)
        board = await connect_udp(address)
        board.write(b"x")
        host = await arrivals.next()
        assert host.peer == f"udp 127.0.0.1:{free_port}"
        with pytest.raises(TransportOpenError, match=f"port {free_port} is already in use"):
            await connect_udp(address)
        board.close()
        await board.wait_closed()


async def test_the_error_about_a_port_in_use_names_the_port() -> None:
    async with listening() as (listener, arrivals):
        with pytest.raises(TransportOpenError, match=r"already in use .*udp://:PORT"):
            await UdpListener.start(UdpAddress("127.0.0.1", port_of(listener)), arrivals)
