from __future__ import annotations

import asyncio

import pytest

from rostether.transports.peers import PeerEntry, PeerTable, SharedMedium
from rostether.transports.transport import Transport
from unit.transports.recorder import Arrivals, Recorder


class FakeMedium:
    """A table whose clock and write buffer the test sets."""

    def __init__(self, max_peers: int = 4) -> None:
        self.now_s = 0.0
        self.unsent_bytes = 0
        self.sent: list[tuple[str, bytes]] = []
        self.arrivals = Arrivals()
        self.table: PeerTable[str] = PeerTable(
            SharedMedium(
                "medium",
                send=lambda key, data: self.sent.append((key, bytes(data))),
                show=lambda key: f"peer {key}",
                write_buffer_bytes=lambda _key: self.unsent_bytes,
            ),
            self.arrivals,
            max_peers=max_peers,
            clock=lambda: self.now_s,
        )

    async def peer(self, key: str) -> tuple[Transport, Recorder]:
        self.table.receive(key, b"")
        return await self.arrivals.next_started()


@pytest.fixture
async def medium() -> FakeMedium:
    return FakeMedium()


async def test_a_peer_that_starts_later_learns_that_the_medium_is_full(medium: FakeMedium) -> None:
    medium.table.receive("a", b"1")
    medium.table.pause_writing()
    peer = await medium.arrivals.next()
    seen = Recorder()
    peer.start(seen)
    assert seen.write_pauses == [True]
    medium.table.resume_writing()
    assert seen.write_pauses == [True, False]
    medium.table.end_all(None)


async def test_write_to_the_peer_it_came_from(medium: FakeMedium) -> None:
    peer, seen = await medium.peer("a")
    peer.write(b"hello")
    medium.table.receive("a", b"back")
    await seen.until_received(b"back")
    assert medium.sent == [("a", b"hello")]
    medium.unsent_bytes = 7
    assert peer.write_buffer_bytes == 7
    medium.table.end_all(None)


async def test_bytes_keep_their_order_around_pause_and_start(medium: FakeMedium) -> None:
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


async def test_pausing_again_before_the_held_bytes_are_delivered_holds_them(medium: FakeMedium) -> None:
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


async def test_the_held_bytes_come_before_the_loss(medium: FakeMedium) -> None:
    peer, seen = await medium.peer("a")
    peer.pause_reading()
    medium.table.receive("a", b"last words")
    medium.table.end_all("is unplugged")
    assert str(await seen.until_lost()) == "peer a is unplugged"
    assert bytes(seen.data) == b"last words"
    peer.write(b"into the void")
    assert (medium.sent, peer.write_buffer_bytes) == ([], 0)


async def test_nothing_is_delivered_after_close(medium: FakeMedium) -> None:
    peer, seen = await medium.peer("a")
    peer.pause_reading()
    medium.table.receive("a", b"unread")
    peer.close()
    peer.close()
    await peer.wait_closed()
    assert await seen.until_lost() is None
    assert (bytes(seen.data), seen.losses) == (b"", [None])


async def test_a_full_medium_pauses_all_writers_and_new_ones(medium: FakeMedium) -> None:
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


async def test_only_the_silent_expire(medium: FakeMedium) -> None:
    _, silent = await medium.peer("a")
    _, lively = await medium.peer("b")
    known = medium.table.add("c", expires=False)
    medium.now_s = 29.0
    medium.table.receive("b", b"here")
    medium.now_s = 30.0
    medium.table.expire()
    assert "peer a was silent for 30 s" in str(await silent.until_lost())
    assert not lively.losses
    assert known.write_buffer_bytes == 0
    assert len(medium.table) == 2
    medium.table.end_all(None)


async def test_a_peer_beyond_the_limit_is_refused() -> None:
    medium = FakeMedium(max_peers=2)
    for key in ("a", "b", "c"):
        medium.table.receive(key, b"x")
    assert (len(medium.table), medium.arrivals.count, medium.table.refusals.count) == (2, 2, 1)
    medium.table.end_all(None)


async def test_a_radio_that_stopped_sending_gives_its_place_to_a_new_one() -> None:
    medium = FakeMedium(max_peers=2)
    for key in ("forged", "board"):
        medium.table.receive(key, b"x")
    _, forged = await medium.arrivals.next_started()
    medium.now_s = 3.0
    medium.table.receive("board", b"x")
    medium.now_s = 6.0
    medium.table.receive("new", b"x")
    assert "disconnected it to make room" in str(await forged.until_lost())
    medium.table.receive("one too many", b"x")
    assert medium.table.refusals.count == 1, "the board and the new one have sent lately"
    medium.table.end_all(None)


def entering(max_peers: int = 4) -> FakeMedium:
    """A medium whose senders become peers by data that contains `F`; `????` asks for it."""
    medium = FakeMedium(max_peers)
    medium.table.entry = PeerEntry(lambda data: b"F" in data, b"????", lambda data: b"A" in data)
    return medium


async def test_a_sender_is_a_peer_after_its_first_frame() -> None:
    medium = entering()
    medium.table.receive("a", b"text")
    assert (len(medium.table), medium.arrivals.count) == (0, 0)
    medium.table.receive("a", b"F")
    _, seen = await medium.arrivals.next_started()
    await seen.until_received(b"textF")
    medium.table.end_all(None)


async def test_a_frame_in_two_datagrams_counts() -> None:
    medium = FakeMedium()
    medium.table.entry = PeerEntry(lambda data: b"FRAME" in data, b"????", lambda data: b"ANSWER" in data)
    medium.table.receive("a", b"FR")
    medium.table.receive("a", b"AME")
    assert len(medium.table) == 1
    medium.table.end_all(None)


async def test_a_peer_that_has_not_answered_gets_no_more_than_it_sent() -> None:
    medium = entering()
    for _ in range(10):
        medium.table.receive("a", b"x")
    assert medium.sent == [("a", b"????")] * 2
    medium.table.receive("a", b"F" * 8)
    peer, _ = await medium.arrivals.next_started()
    for _ in range(10):
        peer.write(b"12345")
    assert sum(len(data) for _, data in medium.sent) <= 18
    for _ in range(3):
        medium.table.receive("a", b"F")
        peer.write(b"y" * 100)
    assert medium.sent[-1] != ("a", b"y" * 100), "a frame that no request causes does not prove the address"
    medium.table.receive("a", b"A")
    peer.write(b"y" * 100)
    assert medium.sent[-1] == ("a", b"y" * 100)
    medium.table.end_all(None)


async def test_an_answer_in_two_datagrams_counts() -> None:
    medium = FakeMedium()
    medium.table.entry = PeerEntry(lambda data: b"F" in data, b"????", lambda data: b"ANSWER" in data)
    medium.table.receive("a", b"F")
    peer, _ = await medium.arrivals.next_started()
    peer.write(b"?")
    medium.table.receive("a", b"ANS")
    medium.table.receive("a", b"WER")
    peer.write(b"y" * 100)
    assert medium.sent[-1] == ("a", b"y" * 100)
    medium.table.end_all(None)


async def test_an_answer_before_the_request_does_not_prove_the_address() -> None:
    medium = entering()
    medium.table.receive("a", b"FA")
    peer, _ = await medium.arrivals.next_started()
    peer.write(b"y" * 100)
    assert medium.sent == []
    medium.table.end_all(None)


async def test_candidates_are_no_peers_and_are_limited() -> None:
    medium = entering(max_peers=2)
    for number in range(1000):
        medium.table.receive(str(number), b"x")
    assert (len(medium.table), medium.sent) == (0, [])
    assert len(medium.table._candidates) <= 256
    medium.table.receive("board", b"F")
    assert len(medium.table) == 1
    medium.table.end_all(None)


async def test_silent_peers_are_replaced_and_sending_ones_are_not() -> None:
    medium = entering(max_peers=3)
    medium.table.receive("board", b"F")
    board, board_seen = await medium.arrivals.next_started()
    board.write(b"?")
    for key in ("forged 1", "forged 2"):
        medium.table.receive(key, b"F")
    _, forged = await medium.arrivals.next_started()
    medium.now_s = 1.0
    medium.table.receive("board", b"A")
    medium.table.receive("new", b"F")
    assert "silent; disconnected it to make room for another board" in str(await forged.until_lost())
    medium.table.receive("forged 3", b"F")
    for number in range(100):
        medium.table.receive(f"forged {number}", b"F")
    medium.now_s = 4.0
    for number in range(100):
        medium.table.receive(f"forged again {number}", b"F")
    assert not board_seen.losses
    medium.now_s = 7.0
    medium.table.receive("new 2", b"F")
    medium.table.receive("new 3", b"F")
    medium.table.receive("new 4", b"F")
    assert await board_seen.until_lost(), "it sends no data any more"
    medium.table.end_all(None)
