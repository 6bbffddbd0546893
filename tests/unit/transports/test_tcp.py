from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from rostether.errors import PeerClosedError, TransportClosedError, TransportOpenError, TransportTimeoutError
from rostether.transports.address import TcpAddress
from rostether.transports.address_parser import parse_address
from rostether.transports.tcp import (
    MAX_CONNECTIONS,
    MAX_CONNECTIONS_PER_HOST,
    TcpListener,
    TcpTransport,
    connect_tcp,
)
from unit.transports.recorder import Arrivals, Recorder
from unit.transports.strangers import is_hung_up, stranger, trust_nobody
from waiting import until


def port_of(listener: TcpListener) -> int:
    return int(listener.address.rpartition(":")[2])


@asynccontextmanager
async def listening(
    max_connections: int = MAX_CONNECTIONS, max_connections_per_host: int = MAX_CONNECTIONS_PER_HOST
) -> AsyncIterator[tuple[TcpListener, Arrivals]]:
    arrivals = Arrivals()
    listener = await TcpListener.start(
        TcpAddress("127.0.0.1", 0),
        arrivals,
        max_connections=max_connections,
        max_connections_per_host=max_connections_per_host,
    )
    try:
        yield listener, arrivals
    finally:
        await listener.close()


@asynccontextmanager
async def connected_to(listener: TcpListener) -> AsyncIterator[tuple[TcpTransport, Recorder]]:
    transport, recorder = (
        await connect_tcp(TcpAddress("127.0.0.1", port_of(listener), connect=True)),
        Recorder(),
    )
    transport.start(recorder)
    try:
        yield transport, recorder
    finally:
        transport.close()
        await transport.wait_closed()


async def test_carry_bytes_both_ways() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, board_seen):
        host, host_seen = await arrivals.next_started()
        board.write(b"from board")
        host.write(bytearray(b"from host"))
        await host_seen.until_received(b"from board")
        await board_seen.until_received(b"from host")
        assert all(type(chunk) is bytes for chunk in host_seen.chunks)
        assert host.can_pause
        assert host.peer.startswith("tcp 127.0.0.1:")
        assert board.peer == f"tcp 127.0.0.1:{port_of(listener)}"


async def test_three_hundred_boards_connect_at_once_while_the_loop_is_busy() -> None:
    async with listening(300, 300) as (listener, _):
        place = "127.0.0.1", port_of(listener)
        # The loop does not run between these.
        boards = [socket.create_connection(place, timeout=0.9) for _ in range(300)]
        await until(lambda: listener.connection_count == 300)
        for board in boards:
            board.close()


async def test_keep_what_came_before_start() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, _):
        board.write(b"early")
        host = await arrivals.next()
        await asyncio.sleep(0.05)
        seen = Recorder()
        host.start(seen)
        await seen.until_received(b"early")


async def test_sockets_send_immediately_and_detect_half_open_peers() -> None:
    async with listening() as (listener, arrivals), connected_to(listener):
        host = await arrivals.next()
        assert isinstance(host, TcpTransport)
        assert host._wire is not None
        sock = host._wire.get_extra_info("socket")
        assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) != 0
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) != 0


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="only Linux can be asked for it")
async def test_bytes_are_acknowledged_at_once_after_answers_too() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, board_seen):
        host, host_seen = await arrivals.next_started()
        assert isinstance(host, TcpTransport)
        assert host._wire is not None
        sock = host._wire.get_extra_info("socket")
        for turn in range(1, 6):
            # The kernel treats a socket that answers soon as interactive.
            board.write(b"?")
            await host_seen.until_received(b"?" * turn)
            host.write(b"!")
            await board_seen.until_received(b"!" * turn)
            assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK) == 1


async def test_pausing_stops_the_sender_and_loses_nothing() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, board_seen):
        host, host_seen = await arrivals.next_started()
        host.pause_reading()
        host.pause_reading()
        chunk = bytes(range(256)) * 256
        sent = 0
        while not board_seen.write_pauses:
            board.write(chunk)
            sent += len(chunk)
            await asyncio.sleep(0)
        assert board.write_buffer_bytes > 0
        before = len(host_seen.data)
        await asyncio.sleep(0.02)
        assert len(host_seen.data) == before
        host.resume_reading()
        await host_seen.until(lambda seen: len(seen.data) == sent)
        assert bytes(host_seen.data) == chunk * (sent // len(chunk))
        await board_seen.until(lambda seen: seen.write_pauses == [True, False])


async def test_reports_when_the_board_disconnects() -> None:
    async with listening() as (listener, arrivals):
        async with connected_to(listener) as (board, board_seen):
            host, host_seen = await arrivals.next_started()
            board.write(b"bye")
            board.close()
            board.write(b"too late")
            error = await host_seen.until_lost()
            assert isinstance(error, PeerClosedError)
            assert host.peer in str(error)
            assert bytes(host_seen.data) == b"bye"
            assert await board_seen.until_lost() is None
        await host.wait_closed()
        host.write(b"into the void")
        host.close()
        assert host_seen.losses == [error]
        assert listener.connection_count == 0


async def test_reports_a_reset_connection() -> None:
    async with listening() as (listener, arrivals):
        raw = socket.create_connection(("127.0.0.1", port_of(listener)))
        _, host_seen = await arrivals.next_started()
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\0\0\0\0\0\0\0")
        raw.close()
        assert type(await host_seen.until_lost()) is TransportClosedError


async def test_a_receiver_that_starts_after_the_end_gets_connection_lost() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, _):
        await arrivals.next()
        board.abort()
        await board.wait_closed()
        seen = Recorder()
        board.start(seen)
        assert await seen.until_lost() is None


async def test_close_flushes_for_a_peer_that_reads() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, board_seen):
        _, host_seen = await arrivals.next_started()
        data = bytes(1_000_000)
        board.write(data)
        board.close()
        await host_seen.until_lost()
        assert len(host_seen.data) == len(data)
        assert board_seen.losses == [None]


async def test_close_drops_data_for_a_peer_that_does_not_read() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (board, board_seen):
        await arrivals.next()
        while not board_seen.write_pauses:
            board.write(bytes(100_000))
            await asyncio.sleep(0)
        loop = asyncio.get_running_loop()
        began_s = loop.time()
        board.close()
        await board.wait_closed()
        assert loop.time() - began_s < 30
        assert board_seen.losses == [None]


async def test_boards_beyond_the_limit_are_refused_and_reported_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with (
        listening(max_connections=2) as (listener, arrivals),
        connected_to(listener),
        connected_to(listener) as (second, _),
    ):
        await arrivals.next_started()
        await arrivals.next_started()
        for _ in range(3):
            async with connected_to(listener) as (_, refused_seen):
                await refused_seen.until_lost()
        assert (arrivals.count, listener.connection_count, listener.refusals.count) == (2, 2, 3)
        second.close()
        await until(lambda: listener.connection_count == 1)
        async with connected_to(listener) as (third, _):
            _, host_seen = await arrivals.next_started()
            third.write(b"in")
            await host_seen.until_received(b"in")
    lines = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert len(lines) == 1
    assert "refused tcp 127.0.0.1:" in lines[0]
    assert "the limit of connected boards (2) is reached" in lines[0]


async def test_refuse_more_connections_of_one_host_than_its_share() -> None:
    async with listening(max_connections_per_host=1) as (listener, arrivals), connected_to(listener):
        await arrivals.next()
        async with connected_to(listener) as (_, refused_seen):
            await refused_seen.until_lost()
        assert (arrivals.count, listener.refusals.count) == (1, 1)


@pytest.mark.parametrize(("allow", "comes"), [("10.0.0.0/8,127.0.0.2", True), ("10.0.0.0/8,::1", False)])
async def test_allow_only_the_networks_named(
    allow: str, comes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    trust_nobody(monkeypatch)
    arrivals = Arrivals()
    address = parse_address(f"tcp://127.0.0.1:0?allow={allow}")
    assert isinstance(address, TcpAddress)
    listener = await TcpListener.start(address, arrivals)
    try:
        async with stranger(port_of(listener)) as (reader, writer):
            writer.write(b"x")
            if comes:
                _, host_seen = await arrivals.next_started()
                await host_seen.until_received(b"x")
            else:
                assert await is_hung_up(reader)
        assert (arrivals.count, listener.refusals.count) == ((1, 0) if comes else (0, 1))
    finally:
        await listener.close()


async def test_this_machine_is_always_allowed() -> None:
    arrivals = Arrivals()
    listener = await TcpListener.start(TcpAddress("127.0.0.1", 0, allow=("10.0.0.0/8",)), arrivals)
    try:
        async with connected_to(listener):
            await arrivals.next_started()
    finally:
        await listener.close()


async def test_the_error_about_a_port_in_use_names_the_port_and_the_next_step() -> None:
    async with listening() as (listener, arrivals):
        port = port_of(listener)
        with pytest.raises(TransportOpenError, match=rf"port {port} is already in use .*tcp://:PORT"):
            await TcpListener.start(TcpAddress("127.0.0.1", port), arrivals)


async def test_a_foreign_host_cannot_be_listened_on() -> None:
    with pytest.raises(TransportOpenError, match=r"192\.0\.2\.1 is not an address of this machine"):
        await TcpListener.start(TcpAddress("192.0.2.1", 0), Arrivals())


async def test_a_missing_listener_is_reported() -> None:
    async with listening() as (listener, _):
        port = port_of(listener)
    with pytest.raises(TransportOpenError, match=rf"no program listens on 127\.0\.0\.1:{port}"):
        await connect_tcp(TcpAddress("127.0.0.1", port, connect=True))


async def test_a_peer_that_does_not_answer_is_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rostether.transports.tcp.CONNECT_LIMIT_S", 0.2)
    with socket.socket() as full:
        full.bind(("127.0.0.1", 0))
        full.listen(0)
        address = TcpAddress("127.0.0.1", full.getsockname()[1], connect=True)
        waiting = []
        try:
            with pytest.raises(TransportTimeoutError, match="does not answer within"):
                for _ in range(20):
                    waiting.append(await connect_tcp(address))
        finally:
            for transport in waiting:
                transport.abort()
                await transport.wait_closed()


async def test_closing_the_listener_ends_its_connections() -> None:
    async with listening() as (listener, arrivals), connected_to(listener) as (_, board_seen):
        _, host_seen = await arrivals.next_started()
        await listener.close()
        await listener.close()
        assert host_seen.losses == [None]
        assert isinstance(await board_seen.until_lost(), TransportClosedError)
        with pytest.raises(TransportOpenError):
            await connect_tcp(TcpAddress("127.0.0.1", port_of(listener), connect=True))


async def test_a_hundred_boards_come_and_go() -> None:
    async with listening(max_connections_per_host=128) as (listener, arrivals):
        boards = await asyncio.gather(
            *(connect_tcp(TcpAddress("127.0.0.1", port_of(listener), connect=True)) for _ in range(100))
        )
        started = [await arrivals.next_started() for _ in boards]
        for number, board in enumerate(boards):
            board.start(Recorder())
            board.write(number.to_bytes(2, "big"))
        for _, seen in started:
            await seen.until(lambda seen: len(seen.data) == 2)
        assert {bytes(seen.data) for _, seen in started} == {
            number.to_bytes(2, "big") for number in range(100)
        }
        for board in boards:
            board.close()
        for _, seen in started:
            await seen.until_lost()
        assert listener.connection_count == 0


async def test_connections_share_one_read_buffer_and_no_bytes() -> None:
    async with (
        listening() as (listener, arrivals),
        connected_to(listener) as (first, _),
        connected_to(listener) as (second, _),
    ):
        (one, seen_by_one), (other, seen_by_other) = (
            await arrivals.next_started(),
            await arrivals.next_started(),
        )
        assert isinstance(one, TcpTransport)
        assert isinstance(other, TcpTransport)
        assert one.get_buffer(-1).obj is other.get_buffer(-1).obj
        for _ in range(50):
            first.write(b"a" * 5000)
            second.write(b"b" * 5000)
            await asyncio.sleep(0)
        for seen in (seen_by_one, seen_by_other):
            await seen.until(lambda seen: len(seen.data) == 250_000)
        assert {bytes(seen_by_one.data), bytes(seen_by_other.data)} == {b"a" * 250_000, b"b" * 250_000}
