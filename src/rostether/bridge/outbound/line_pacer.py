"""Limits how much is written to a serial line, so that urgent frames wait behind little data.

The operating system would accept seconds of a slow line's backlog at once, and a time answer would wait for
all of it. Here, at most 20 ms of line time are in the port; the rest waits in the outbox, which can reorder
it.

The baud rate alone does not give a line's speed: boards with built-in USB ignore it. If a port is empty
before its line can have transferred all bytes, its assumed speed doubles. If it still holds bytes, the
assumed speed is the baud rate again. An adapter's own buffer looks like a fast line until it is full; the
largest common one holds 0.1 s of 57600 baud.
"""

from __future__ import annotations

# One start bit, eight data bits, one stop bit.
BITS_PER_BYTE = 10
# The line stays busy through a late wake-up of this length, and nothing urgent waits longer than this.
WINDOW_S = 0.020
# Slow lines still accept a few small frames at once.
MIN_WINDOW_BYTES = 64
# 370 kB/s, the limit of full-speed USB, is 64 times the speed of 57600 baud.
MAX_SPEED_FACTOR = 64.0


class LinePacer:
    """Models a line of `baud` bits per second; does not read a clock."""

    def __init__(self, baud: int) -> None:
        self.bytes_per_s = baud / BITS_PER_BYTE
        self._speed_factor = 1.0
        self._idle_at_s = 0.0

    def room_bytes(self, now_s: float) -> int:
        """Return how many bytes may be written now; one message may exceed them."""
        waiting_s = max(0.0, self._idle_at_s - now_s)
        return self._window_bytes() - int(waiting_s * self._speed())

    def written(self, count_bytes: int, now_s: float) -> None:
        """Record that bytes were written to the port."""
        self._idle_at_s = max(self._idle_at_s, now_s) + count_bytes / self._speed()

    def observe(self, unsent_bytes: int, now_s: float) -> None:
        """Record how many of the written bytes are still in the port."""
        if unsent_bytes:
            self._speed_factor = 1.0
            self._idle_at_s = now_s + unsent_bytes / self.bytes_per_s
        elif self._idle_at_s > now_s:
            self._speed_factor = min(self._speed_factor * 2, MAX_SPEED_FACTOR)
            self._idle_at_s = now_s

    def wait_s(self, now_s: float) -> float:
        """Return the time until half of the window is free, at least a millisecond."""
        half_s = self._window_bytes() / self._speed() / 2
        return max(0.001, self._idle_at_s - now_s - half_s)

    def _speed(self) -> float:
        return self.bytes_per_s * self._speed_factor

    def _window_bytes(self) -> int:
        return max(MIN_WINDOW_BYTES, int(self._speed() * WINDOW_S))
