"""Two transports connected in memory, for tests and for boards in this process.

Bytes that one side writes arrive at the other in the event loop's next turn. A manipulator gets every chunk
and returns the bytes that arrive, such as fewer or other bytes, to simulate a lossy line.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from enum import Enum
from typing import TypeAlias

from rostether.errors import TransportClosedError, TransportError
from rostether.transports.transport import HIGH_WATER_BYTES, LOW_WATER_BYTES, PausingTransport, Receiver


class Direction(Enum):
    """The direction of a chunk between the two transports of a pair."""

    FIRST_TO_SECOND = 1
    SECOND_TO_FIRST = 2


Manipulator: TypeAlias = Callable[[bytes, Direction], bytes]


def memory_pair(
    manipulator: Manipulator | None = None,
    *,
    can_pause: bool = True,
    names: tuple[str, str] = ("memory first", "memory second"),
) -> tuple[MemoryTransport, MemoryTransport]:
    """Create two connected transports; with `can_pause=False`, a paused reader loses data beyond 64 KiB."""
    first = MemoryTransport(names[1], Direction.FIRST_TO_SECOND, manipulator, can_pause=can_pause)
    second = MemoryTransport(names[0], Direction.SECOND_TO_FIRST, manipulator, can_pause=can_pause)
    first._other, second._other = second, first
    return first, second


class MemoryTransport(PausingTransport):
    """One end of a pair; made by `memory_pair`."""

    def __init__(
        self, peer: str, direction: Direction, manipulator: Manipulator | None, *, can_pause: bool
    ) -> None:
        super().__init__()
        self.peer = peer
        self._direction = direction
        self._manipulator = manipulator
        self.can_pause = can_pause
        self._other = self
        self._arrived: deque[bytes] = deque()
        self._arrived_bytes = 0
        self._is_delivery_scheduled = False
        self._is_paused = False
        self._has_ended = False
        self._error: TransportError | None = None
        self._end_event = asyncio.Event()

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that the other end has not received yet."""
        return 0 if self._has_ended else self._other._arrived_bytes

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once. Bytes received earlier are kept."""
        self._receiver = receiver
        if self._is_writing_paused:
            receiver.pause_writing()
        self._schedule()

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended."""
        if self._has_ended or not data:
            return
        chunk = bytes(data)
        if self._manipulator is not None:
            chunk = self._manipulator(chunk, self._direction)
        if chunk:
            self._other._arrive(chunk)
        if self.can_pause and not self._is_writing_paused and self.write_buffer_bytes > HIGH_WATER_BYTES:
            self.pause_writing()

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""
        self._is_paused = True

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""
        self._is_paused = False
        self._schedule()

    def close(self) -> None:
        """End the transport; the other end still receives the written data. Idempotent."""
        if self._has_ended:
            return
        self._arrived.clear()
        self._arrived_bytes = 0
        self._end(None)
        self._other._end(TransportClosedError(f"{self._other.peer} ended the connection"))

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""
        await self._end_event.wait()

    def _arrive(self, chunk: bytes) -> None:
        if self._has_ended:
            return
        if not self.can_pause and self._arrived_bytes + len(chunk) > HIGH_WATER_BYTES:
            return
        self._arrived.append(chunk)
        self._arrived_bytes += len(chunk)
        self._schedule()

    def _end(self, error: TransportError | None) -> None:
        if not self._has_ended:
            self._has_ended = True
            self._error = error
            self._end_event.set()
            self._schedule()

    def _schedule(self) -> None:
        if self._is_delivery_scheduled or self._receiver is None or (self._is_paused and not self._has_ended):
            return
        if self._arrived or self._has_ended:
            self._is_delivery_scheduled = True
            asyncio.get_running_loop().call_soon(self._deliver)

    def _deliver(self) -> None:
        self._is_delivery_scheduled = False
        receiver = self._receiver
        if receiver is None:
            return
        while self._arrived and (not self._is_paused or self._has_ended):
            chunk = self._arrived.popleft()
            self._arrived_bytes -= len(chunk)
            receiver.data_received(chunk)
        self._other._drained()
        if self._has_ended and not self._arrived:
            self._receiver = None
            receiver.connection_lost(self._error)

    def _drained(self) -> None:
        is_low = self.write_buffer_bytes <= LOW_WATER_BYTES
        if self._is_writing_paused and is_low and not self._has_ended:
            self.resume_writing()
