"""Shares the radio at the host between all boards: whose turn it is, and the packets in progress. Sans I/O.

    put ──> queue of each board ──> next_packets (in turn, as the radio has room) ──> radio
                                          ^                                             │
                                          └───────── finished (transmit status) <───────┘

A radio has room for two packets and drops more without a report, so at most two wait for their status. A
board that does not acknowledge keeps the radio busy with retries; such boards share one slot.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterator
from typing import Generic, NamedTuple, TypeVar

from msgspec import Struct, field

from rostether.transports.xbee.packets import TransmitStatus

Key = TypeVar("Key", bound=Hashable)

# The packets for which a radio has room.
WINDOW_PACKETS = 2
# The longest frame that an Uno accepts, 288 bytes: it must not wait for other boards between its packets.
TURN_PACKETS = 3
# 0.7 s of 57600 baud for each board; the outbox above queues messages in their order.
QUEUE_LIMIT_BYTES = 4 * 1024
# Longer than all retries of a packet; a mesh that searches a route can take longer, and its report is then
# ignored.
STATUS_LIMIT_S = 1.0

_MAX_FRAME_ID = 255
# Bytes that wait for disconnected boards are still sent (they request a stop); forged senders must not
# fill the memory.
_MAX_BOARDS = 128


class Packet(NamedTuple, Generic[Key]):
    """A packet to send now; the radio reports its end with `frame_id`."""

    key: Key
    payload: bytes
    frame_id: int


class Finished(NamedTuple, Generic[Key]):
    """The end of a packet; `status` is None if the radio never reported it."""

    key: Key
    status: TransmitStatus | None


class _WaitingBytes(Struct):
    data: bytearray = field(default_factory=bytearray)
    has_failed: bool = False
    is_gone: bool = False


class SendQueue(Generic[Key]):
    """The packets to all boards of one radio; `packet_bytes` returns how much one packet can hold."""

    def __init__(self, packet_bytes: Callable[[], int]) -> None:
        self._packet_bytes = packet_bytes
        self._boards: dict[Key, _WaitingBytes] = {}
        self._ready: deque[Key] = deque()
        self._turn_packets = 0
        self._in_flight: dict[int, tuple[Key, float]] = {}
        self._frame_id = 0

    def put(self, key: Key, data: bytes | bytearray | memoryview) -> bool:
        """Queue bytes for a board; return False if its queue is full, which drops all of them."""
        board = self._boards.setdefault(key, _WaitingBytes())
        board.is_gone = False
        # A single message may be longer than the limit.
        if board.data and len(board.data) + len(data) > QUEUE_LIMIT_BYTES:
            return False
        if data and not board.data:
            self._ready.append(key)
        board.data += data
        return True

    @property
    def is_empty(self) -> bool:
        """Whether no packet waits or is in flight."""
        return not (self._ready or self._in_flight)

    def waiting_bytes(self, key: Key) -> int:
        """Return how many bytes wait for a board."""
        board = self._boards.get(key)
        return len(board.data) if board is not None else 0

    def release(self, key: Key) -> None:
        """Forget a disconnected board, as soon as its waiting data is sent."""
        board = self._boards.get(key)
        if board is None:
            return
        if board.data and len(self._boards) <= _MAX_BOARDS:
            board.is_gone = True
            return
        del self._boards[key]
        if key in self._ready:
            self._ready.remove(key)
            self._turn_packets = 0

    def next_packets(self, now_s: float) -> Iterator[Packet[Key]]:
        """Return the packets for which the radio has room now."""
        while len(self._in_flight) < WINDOW_PACKETS and (key := self._choose()) is not None:
            board = self._boards[key]
            size = self._packet_bytes()
            payload = bytes(board.data[:size])
            del board.data[:size]
            self._turn_packets += 1
            if not board.data:
                self._ready.popleft()
                self._turn_packets = 0
                if board.is_gone:
                    del self._boards[key]
            elif self._turn_packets >= TURN_PACKETS:
                self._rotate()
            frame_id = self._next_frame_id()
            self._in_flight[frame_id] = key, now_s
            yield Packet(key, payload, frame_id)

    def finished(self, status: TransmitStatus) -> Finished[Key] | None:
        """Handle the radio's report; return whose packet it was; None if `give_up` has returned it."""
        key, _ = self._in_flight.pop(status.frame_id, (None, 0.0))
        if key is None:
            return None
        self._note(key, has_failed=not status.is_delivered)
        return Finished(key, status)

    def give_up(self, now_s: float) -> list[Finished[Key]]:
        """Return the packets that got no report for too long, and give their slots to others."""
        late = [
            (frame_id, key)
            for frame_id, (key, sent_s) in self._in_flight.items()
            if now_s - sent_s >= STATUS_LIMIT_S
        ]
        for frame_id, key in late:
            del self._in_flight[frame_id]
            self._note(key, has_failed=True)
        return [Finished(key, None) for _, key in late]

    def get_timer(self) -> float | None:
        """Return when `give_up` is due, None if no packet is in flight."""
        sent = [sent_s for _, sent_s in self._in_flight.values()]
        return min(sent) + STATUS_LIMIT_S if sent else None

    def note_received(self, key: Key) -> None:
        """Record data of a board, which shows that it is in range."""
        self._note(key, has_failed=False)

    def _note(self, key: Key, *, has_failed: bool) -> None:
        if (board := self._boards.get(key)) is not None:
            board.has_failed = has_failed

    def _choose(self) -> Key | None:
        """Return the board whose turn it is, at the head of the ready ones; None if all must wait."""
        in_flight = (self._boards[key] for key, _ in self._in_flight.values() if key in self._boards)
        is_taken = any(board.has_failed for board in in_flight)
        for _ in range(len(self._ready)):
            key = self._ready[0]
            if not (is_taken and self._boards[key].has_failed):
                return key
            self._rotate()
        return None

    def _rotate(self) -> None:
        self._ready.rotate(-1)
        self._turn_packets = 0

    def _next_frame_id(self) -> int:
        while True:
            self._frame_id = self._frame_id % _MAX_FRAME_ID + 1
            if self._frame_id not in self._in_flight:
                return self._frame_id
