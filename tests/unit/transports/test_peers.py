from __future__ import annotations

import asyncio

import pytest

from rostether.errors import TransportClosedError
from rostether.transports.peers import PeerTable
from rostether.transports.transport import Transport
from unit.transports.recorder import Arrivals, Recorder


class Medium:
    """A table whose clock and write buffer the test sets."""

    def __init__(self, max_peers: int = 4) -> None:
        self.now_s = 0.0
        self.unsent_bytes = 0
        self.sent: list[tuple[str, bytes]] = []
        self.arrivals = Arrivals()
        self.table: PeerTable[str] = PeerTable(
            "medium",
            self.arrivals,
            send=lambda key, data: self.sent.append((key, bytes(data))),
            show=lambda key: f"peer {key}",
            write_buffer_bytes=lambda: self.unsent_bytes,
            max_peers=max_peers,
            idle_limit_s=10.0,
            clock=lambda: self.now_s,
        )

    async def peer(self, key: str) -> tuple[Transport, Recorder]:
        self.table.receive(key, b"")
        return await self.arrivals.next_started()


@pytest.fixture
async def medium() -> Medium:
    return Medium()


async def test_write_to_the_peer_it_came_from(medium: Medium) -> None:
    peer, seen = await medium.peer("a")
    peer.write(b"hello")
    medium.table.receive("a", b"back")
    await seen.until_received(b"back")
    assert medium.sent == [("a", b"hello")]
    medium.unsent_bytes = 7
    assert peer.write_buffer_bytes == 7
    medium.table.end_all(None)


async def test_bytes_keep_their_order_around_pause_and_start(medium: Medium) -> None:
    medium.table.receive("a", b"1")
    peer = await medium.arrivals.next()
    seen = Recorder()
    peer.start(seen)
    medium.table.receive("a", b"2")
    await seen.until_received(b"12")
    peer.pause_reading()
    medium.table.receive("a", b"3")
    peer.resume_reading()
    medium.table.receive("a", b"4")
    await seen.until_received(b"1234")
    medium.table.end_all(None)


async def test_pausing_again_before_the_held_bytes_are_delivered_holds_them(medium: Medium) -> None:
    peer, seen = await medium.peer("a")
    peer.pause_reading()
    medium.table.receive("a", b"x")
    peer.resume_reading()
    peer.pause_reading()
    await asyncio.sleep(0)
    assert not seen.data
    peer.resume_reading()
    await seen.until_received(b"x")
    medium.table.end_all(None)


async def test_the_held_bytes_come_before_the_loss(medium: Medium) -> None:
    peer, seen = await medium.peer("a")
    peer.pause_reading()
    medium.table.receive("a", b"last words")
    error = TransportClosedError("unplugged")
    medium.table.end_all(error)
    assert await seen.until_lost() is error
    assert bytes(seen.data) == b"last words"
    peer.write(b"into the void")
    assert (medium.sent, peer.write_buffer_bytes) == ([], 0)


async def test_after_our_own_close_nothing_comes(medium: Medium) -> None:
    peer, seen = await medium.peer("a")
    peer.pause_reading()
    medium.table.receive("a", b"unread")
    peer.close()
    peer.close()
    await peer.wait_closed()
    assert await seen.until_lost() is None
    assert (bytes(seen.data), seen.losses) == (b"", [None])


async def test_a_full_medium_pauses_every_writer_and_those_who_come_meanwhile(medium: Medium) -> None:
    _, first = await medium.peer("a")
    medium.table.pause_writing()
    late: list[Recorder] = []

    def start(transport: Transport) -> None:
        late.append(Recorder())
        transport.start(late[0])

    medium.table._on_transport = start
    medium.table.receive("b", b"")
    medium.table.resume_writing()
    assert first.write_pauses == late[0].write_pauses == [True, False]
    medium.table.end_all(None)


async def test_only_the_silent_expire(medium: Medium) -> None:
    _, silent = await medium.peer("a")
    _, lively = await medium.peer("b")
    known = medium.table.add("c", expires=False)
    medium.now_s = 9.0
    medium.table.receive("b", b"here")
    medium.now_s = 10.0
    medium.table.expire(medium.now_s)
    assert "peer a was silent for 10 s" in str(await silent.until_lost())
    assert not lively.losses
    assert known.write_buffer_bytes == 0
    assert len(medium.table) == 2
    medium.table.end_all(None)


async def test_a_peer_too_many_is_refused() -> None:
    medium = Medium(max_peers=2)
    for key in ("a", "b", "c"):
        medium.table.receive(key, b"x")
    assert (len(medium.table), medium.arrivals.count, medium.table.refusals.count) == (2, 2, 1)
    medium.table.end_all(None)
