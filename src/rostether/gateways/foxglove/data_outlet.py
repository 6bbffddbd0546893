"""Messages of topics on their way to one client: gathered over a turn of the event loop, or waiting.

They are written past the WebSocket library (see `data_frames.py`); what a client reads too slowly waits in
bounded queues, where the oldest is lost first.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from rostether.gateways.foxglove.data_frames import add_data_frames
from rostether.gateways.foxglove.waiting_messages import WaitingMessages

GATHER_S = 0.01
"""A message goes at once when none has gone for so long; those of a flood go together, less often than a
screen is drawn: each write costs more than all the rest."""

_GATHERED_BYTES = 256 << 10
_DRAIN_BYTES = 64 << 10  # written at once of what waited: enough for one system call


class DataOutlet:
    """`write` sends bytes; `dropped` is called with the number of newly lost messages."""

    def __init__(
        self, waiting_bytes: int, write: Callable[[bytes], None], dropped: Callable[[int], None]
    ) -> None:
        self._is_open = True
        self._write = write
        self._dropped = dropped
        self._loop = asyncio.get_running_loop()
        self._pieces: list[bytes] = []
        self._pieces_bytes = 0
        self._is_flush_due = False
        self._flushed_s = 0.0
        self._is_paused = False
        self._waiting = WaitingMessages(waiting_bytes)
        self._told_dropped = 0

    def end(self) -> None:
        """Write nothing more."""
        self._is_open = False
        self._pieces.clear()
        self._pieces_bytes = 0

    def pause(self) -> None:
        """Let messages wait."""
        self._is_paused = True

    def resume(self) -> None:
        """Send what waited."""
        self._is_paused = False
        self._drain()

    def send(self, subscription_id: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Send messages of a topic, or let them wait."""
        if not self._is_open:
            return
        if self._is_paused or self._waiting:
            self._waiting.add(subscription_id, time_ns, payloads)
            self._tell_dropped()
            return
        self._pieces_bytes += add_data_frames(self._pieces, subscription_id, time_ns, payloads)
        if self._pieces_bytes > _GATHERED_BYTES:
            self.flush()
        elif not self._is_flush_due:
            self._is_flush_due = True
            due_s = self._flushed_s + GATHER_S
            if self._loop.time() >= due_s:
                # What else comes in this turn of the loop goes with it.
                self._loop.call_soon(self._flush_due)
            else:
                self._loop.call_at(due_s, self._flush_due)

    def forget(self, subscription_id: int) -> None:
        """Drop what waits for a subscription that has ended."""
        self._waiting.forget(subscription_id)

    def flush(self) -> None:
        """Write what was gathered."""
        pieces = self._pieces
        if not pieces:
            return
        self._pieces, self._pieces_bytes = [], 0
        if not self._is_open:
            return
        self._flushed_s = self._loop.time()
        self._write(b"".join(pieces))

    def _flush_due(self) -> None:
        self._is_flush_due = False
        self.flush()

    def _drain(self) -> None:
        while self._waiting and not self._is_paused and self._is_open:
            while self._waiting and self._pieces_bytes < _DRAIN_BYTES:
                subscription_id, time_ns, payload = self._waiting.pop()
                self._pieces_bytes += add_data_frames(self._pieces, subscription_id, time_ns, [payload])
            self.flush()

    def _tell_dropped(self) -> None:
        count = self._waiting.dropped_count - self._told_dropped
        if count:
            self._told_dropped += count
            self._dropped(count)
