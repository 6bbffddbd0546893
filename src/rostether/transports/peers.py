"""Many peers on one medium (a UDP socket, a radio), each as its own transport."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

from msgspec import Struct, field

from rostether.errors import TransportClosedError, TransportError
from rostether.transports.link_quality import LinkQuality
from rostether.transports.refusals import RefusalLog
from rostether.transports.transport import PausingTransport, Receiver, Transport

PeerKey = TypeVar("PeerKey", bound=Hashable)

# Addresses of senders are easily forged, and each new one becomes a session: this limits the cost.
MAX_PEERS = 64
# A healthy board sends every 2.5 s; one that was silent for this long loses its place.
IDLE_LIMIT_S = 30.0
# The bytes kept for a paused receiver, or before its start; this medium has no flow control.
_HELD_LIMIT_BYTES = 64 * 1024
# Senders without a frame yet; each keeps at most one datagram and a piece of the next.
_MAX_CANDIDATES = 256
_CANDIDATE_BYTES = 2048
# A board on Wi-Fi answers a request within this time.
UNANSWERED_LIMIT_S = 0.5
# Two periods of a healthy board; a shorter silence may be a sketch that sleeps.
SILENT_LIMIT_S = 5.0


class PeerEntry(Struct, frozen=True):
    """How a sender becomes a peer: by a frame; `request` asks for one. An answer proves its address.

    Only a board without a host answers `call`, so it can be broadcast.
    """

    is_frame: Callable[[bytes], bool]
    request: bytes
    is_answer: Callable[[bytes], bool]
    call: bytes = b""


class _Candidate(Struct):
    data: bytearray = field(default_factory=bytearray)
    allowance_bytes: int = 0
    sent_bytes: int = 0


class SharedMedium(Struct, Generic[PeerKey], frozen=True):
    """The medium that peers share: how to send to a peer, and how to describe it.

    `show` returns its name for users, `host_of` its host, `write_buffer_bytes` the bytes that wait for it.
    """

    name: str
    send: Callable[[PeerKey, bytes | bytearray | memoryview], None]
    show: Callable[[PeerKey], str]
    write_buffer_bytes: Callable[[PeerKey], int]
    host_of: Callable[[PeerKey], str | None] = lambda _key: None
    quality_of: Callable[[PeerKey], LinkQuality | None] = lambda _key: None


class PeerTransport(PausingTransport, Generic[PeerKey]):
    """One peer of a shared medium as a `Transport`; made by a `PeerTable`."""

    can_pause = False

    def __init__(
        self, table: PeerTable[PeerKey], key: PeerKey, peer: str, remote: str | None, *, expires: bool
    ) -> None:
        super().__init__()
        self.remote = remote
        self.key = key
        self.quality = table.medium.quality_of(key)
        self.expires = expires
        self.received_at_s = table.now_s()
        # Whether it has answered. Until then, its address may be forged, and it gets no more bytes than it
        # sent.
        self.has_answered = not expires or table.entry is None
        self.allowance_bytes = 0
        self._was_written_to = False
        self._unproven = bytearray()
        self._table = table
        self.peer = peer
        self._held = bytearray()
        self._is_paused = False
        self._is_lost = False
        self._error: TransportError | None = None
        self._ended = asyncio.get_running_loop().create_future()

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that are still waiting."""
        return 0 if self._is_lost else self._table.medium.write_buffer_bytes(self.key)

    def is_replaceable(self, now_s: float) -> bool:
        """Return whether it was silent long enough for a new peer to replace it."""
        limit_s = SILENT_LIMIT_S if self.has_answered else UNANSWERED_LIMIT_S
        return self.expires and now_s - self.received_at_s >= limit_s

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once. Bytes received earlier are kept."""
        self._receiver = receiver
        if self._is_writing_paused and not self._is_lost:
            receiver.pause_writing()
        if self._held or self._is_lost:
            asyncio.get_running_loop().call_soon(self._catch_up)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Send bytes. Never blocks; does nothing once the transport has ended.

        A peer that has not answered yet gets no more bytes than it sent; the rest is dropped.
        """
        if self._is_lost:
            return
        if not self.has_answered:
            if len(data) > self.allowance_bytes:
                return
            self.allowance_bytes -= len(data)
            self._was_written_to = True
        self._table.medium.send(self.key, data)

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading; data beyond 64 KiB is lost. Idempotent."""
        self._is_paused = True

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""
        self._is_paused = False
        if self._held:
            asyncio.get_running_loop().call_soon(self._catch_up)

    def close(self) -> None:
        """End the transport. Idempotent."""
        self.end(None)

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""
        await asyncio.shield(self._ended)

    def deliver(self, data: bytes) -> None:
        """Handle data from this peer."""
        self.received_at_s = self._table.now_s()
        if not self.has_answered:
            self._seek_answer(data)
        if self._receiver is not None and not self._is_paused and not self._held:
            self._receiver.data_received(data)
        elif len(self._held) + len(data) <= _HELD_LIMIT_BYTES:
            self._held += data

    def _seek_answer(self, data: bytes) -> None:
        self.allowance_bytes += len(data)
        if not self._was_written_to or (entry := self._table.entry) is None:
            return
        self._unproven += data  # an answer may be cut into several datagrams
        del self._unproven[:-_CANDIDATE_BYTES]
        self.has_answered = entry.is_answer(bytes(self._unproven))

    def end(self, error: TransportError | None) -> None:
        """End the transport for a reason; None if this side ends it. Idempotent."""
        if self._is_lost:
            return
        self._is_lost = True
        self._error = error
        if error is None:
            self._held.clear()
        self._table.forget(self)
        if not self._ended.done():
            self._ended.set_result(None)
        if self._receiver is not None:
            asyncio.get_running_loop().call_soon(self._catch_up)

    def _catch_up(self) -> None:
        receiver = self._receiver
        if receiver is None:
            return
        if self._held and (self._is_lost or not self._is_paused):
            data = bytes(self._held)
            self._held.clear()
            receiver.data_received(data)
        if self._is_lost:
            self._receiver = None
            receiver.connection_lost(self._error)


class PeerTable(Generic[PeerKey]):
    """The peers of one medium, limited in number; silent peers expire."""

    def __init__(
        self,
        medium: SharedMedium[PeerKey],
        on_transport: Callable[[Transport], None],
        *,
        max_peers: int = MAX_PEERS,
        clock: Callable[[], float] | None = None,
        on_forget: Callable[[PeerKey], None] | None = None,
        entry: PeerEntry | None = None,
    ) -> None:
        self.entry = entry
        self._candidates: dict[PeerKey, _Candidate] = {}
        self.medium = medium
        self.now_s = clock if clock is not None else asyncio.get_running_loop().time
        self.refusals = RefusalLog(medium.name, self.now_s)
        self._on_transport = on_transport
        self._on_forget = on_forget
        self._max_peers = max_peers
        self._peers: dict[PeerKey, PeerTransport[PeerKey]] = {}
        self._sweep_timer: asyncio.TimerHandle | None = None
        self._is_writing_paused = False

    def __len__(self) -> int:
        return len(self._peers)

    def receive(self, key: PeerKey, data: bytes) -> None:
        """Deliver to the peer's transport, which is created for a new peer; see `PeerEntry`.

        At the limit, a new peer replaces the one that was silent for the longest time: first one that has
        never answered, then one that has stopped sending. A peer that sends keeps its place.
        """
        peer = self._peers.get(key)
        if peer is None:
            sent_bytes = 0
            if self.entry is not None:
                candidate = self._candidates.pop(key, None) or _Candidate()
                if not self._has_sent_frame(key, candidate, data, self.entry):
                    return
                data, sent_bytes = bytes(candidate.data), candidate.sent_bytes
            if len(self._peers) >= self._max_peers:
                self._make_room()
            if len(self._peers) >= self._max_peers:
                reason = f"the limit of connected boards ({self._max_peers}) is reached"
                self.refusals.refuse(self.medium.show(key), reason)
                return
            peer = self.add(key)
            peer.allowance_bytes -= sent_bytes
        peer.deliver(data)

    def _has_sent_frame(self, key: PeerKey, candidate: _Candidate, data: bytes, entry: PeerEntry) -> bool:
        """Return whether a sender has sent a frame; ask it for one until then."""
        candidate.data += data
        del candidate.data[:-_CANDIDATE_BYTES]
        # Most datagrams begin with a frame.
        if entry.is_frame(data) or (
            len(candidate.data) > len(data) and entry.is_frame(bytes(candidate.data))
        ):
            return True
        candidate.allowance_bytes += len(data)
        if candidate.allowance_bytes >= len(entry.request):
            candidate.allowance_bytes = 0
            candidate.sent_bytes += len(entry.request)
            self.medium.send(key, entry.request)
        if len(self._candidates) >= _MAX_CANDIDATES:
            del self._candidates[next(iter(self._candidates))]
        self._candidates[key] = candidate
        return False

    def _make_room(self) -> None:
        self.expire()
        if len(self._peers) < self._max_peers:
            return
        silent = [peer for peer in self._peers.values() if peer.is_replaceable(self.now_s())]
        if silent:
            peer = min(silent, key=lambda peer: (peer.has_answered, peer.received_at_s))
            peer.end(
                TransportClosedError(
                    f"{peer.peer} was silent; disconnected it to make room for another board"
                )
            )

    def add(self, key: PeerKey, *, expires: bool = True) -> PeerTransport[PeerKey]:
        """Create a peer's transport and announce it; a peer of the link address does not expire."""
        peer = PeerTransport(self, key, self.medium.show(key), self.medium.host_of(key), expires=expires)
        self._peers[key] = peer
        if expires and self._sweep_timer is None:
            self._schedule_sweep()
        self._on_transport(peer)
        if self._is_writing_paused:
            peer.pause_writing()
        return peer

    def forget(self, peer: PeerTransport[PeerKey]) -> None:
        """Drop a closed peer; it becomes a new one when it sends again."""
        if self._peers.get(peer.key) is peer:
            del self._peers[peer.key]
            if self._on_forget is not None:
                self._on_forget(peer.key)

    def expire(self) -> None:
        """End every peer that was silent for too long."""
        now_s = self.now_s()
        for peer in list(self._peers.values()):
            if peer.expires and now_s - peer.received_at_s >= IDLE_LIMIT_S:
                silence = f"{peer.peer} was silent for {IDLE_LIMIT_S:g} s"
                peer.end(TransportClosedError(f"{silence}; check its power and its network"))

    def pause_writing(self) -> None:
        """Notify every peer that the medium's write buffer is full."""
        self._is_writing_paused = True
        for peer in list(self._peers.values()):
            peer.pause_writing()

    def resume_writing(self) -> None:
        """Notify every peer that the medium's write buffer has drained."""
        self._is_writing_paused = False
        for peer in list(self._peers.values()):
            peer.resume_writing()

    def end_all(self, reason: str | None) -> None:
        """End every peer for a reason, which follows its name; None if this side ends them."""
        if self._sweep_timer is not None:
            self._sweep_timer.cancel()
            self._sweep_timer = None
        for peer in list(self._peers.values()):
            peer.end(None if reason is None else TransportClosedError(f"{peer.peer} {reason}"))

    def _schedule_sweep(self) -> None:
        # A silent peer ends late by at most this period, a quarter of the limit.
        self._sweep_timer = asyncio.get_running_loop().call_later(IDLE_LIMIT_S / 4, self._sweep)

    def _sweep(self) -> None:
        self._sweep_timer = None
        self.expire()
        if any(peer.expires for peer in self._peers.values()):
            self._schedule_sweep()
