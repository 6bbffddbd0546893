"""How much a serial line may be given now, so that little waits in buffers that nothing can overtake.

The operating system would take seconds of a slow line's backlog at once, and a time answer would stand behind
all of it. Here at most 20 ms of line time is on its way; the rest waits in the outbox, where order is ours.
"""

from __future__ import annotations

# One start bit, eight data bits, one stop bit.
BITS_PER_BYTE = 10
# The line stays busy through a late wake-up of this length, and nothing urgent waits longer than this.
WINDOW_S = 0.020
# Slow lines still take a handful of small frames at once.
MIN_WINDOW_BYTES = 64


class LinePacer:
    """Models a line of `baud` bits a second; knows no clock."""

    def __init__(self, baud: int) -> None:
        self.bytes_per_s = baud / BITS_PER_BYTE
        self._window_bytes = max(MIN_WINDOW_BYTES, int(self.bytes_per_s * WINDOW_S))
        self._idle_at_s = 0.0

    def room_bytes(self, now_s: float) -> int:
        """Return how many bytes may be written now; one message may overshoot it."""
        waiting_s = self._idle_at_s - now_s
        if waiting_s <= 0.0:
            return self._window_bytes
        return self._window_bytes - int(waiting_s * self.bytes_per_s)

    def written(self, count_bytes: int, now_s: float) -> None:
        """Learn that bytes were given to the line."""
        self._idle_at_s = max(self._idle_at_s, now_s) + count_bytes / self.bytes_per_s

    def wait_s(self, now_s: float) -> float:
        """Return how long until half the window is free, at least a millisecond."""
        half_s = self._window_bytes / self.bytes_per_s / 2
        return max(0.001, self._idle_at_s - now_s - half_s)
