"""Limits the bytes that are read from one connection at a time, so that the others get their turn soon.

A byte of a flood of messages costs 0.1 µs, a hostile byte a few µs. `TURN_S` and the highest recent cost of
a byte limit the next read. It is also at most twice as large as the last one.
"""

from __future__ import annotations

# The time to handle one read of a connection: a message still takes less than 10 ms when a hundred devices
# are connected.
TURN_S = 0.002

# The first chunk after a quiet time: if it has only announcements, it costs 4 ms.
FIRST_READ_BYTES = 2 * 1024

# Announcements cost the most, 2 µs a byte; with smaller reads, the wake-ups would cost more.
MIN_READ_BYTES = 1024

# The remaining share of a cost after each read: half after 69 reads. Hostile bytes arrive in long runs; a
# pause of the garbage collector, which looks the same, has no effect after 0.3 MB.
DECAY = 0.99


class ReadTurn:
    """The size of a connection's next read, at most `max_bytes`; does not read a clock."""

    def __init__(self, max_bytes: int) -> None:
        self.size_bytes = min(FIRST_READ_BYTES, max_bytes)
        self._max_bytes = max_bytes
        self._byte_cost_s = 0.0

    def note_quiet(self) -> None:
        """Record a read that is too small to measure."""
        self.size_bytes = min(self.size_bytes, FIRST_READ_BYTES)

    def note_cost(self, read_bytes: int, used_s: float) -> None:
        """Record the cost of a read, in seconds of CPU."""
        byte_cost_s = self._byte_cost_s = max(used_s / read_bytes, self._byte_cost_s * DECAY)
        size_bytes = min(2 * self.size_bytes, self._max_bytes)
        if size_bytes * byte_cost_s > TURN_S:
            size_bytes = max(int(TURN_S / byte_cost_s), MIN_READ_BYTES)
        self.size_bytes = size_bytes
