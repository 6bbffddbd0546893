"""How much of one connection is read at a time, so that the others get their turn soon.

A byte of a flood of messages costs 0.1 µs, one of hostile bytes a few. The size follows from the last reads:
as much as costs one turn at the highest recent cost, and at most twice the last size.
"""

from __future__ import annotations

# What one connection may use at a time: with a hundred others a message still takes less than 10 ms.
TURN_S = 0.002

# The first chunk after a quiet time, in bytes: a chunk of announcements only costs 4 ms then.
FIRST_READ_BYTES = 2 * 1024

# Announcements cost most, 2 µs a byte, and what is smaller than this is not worth the wake-up.
MIN_READ_BYTES = 1024

# What is left of a price after each read: half after 69. Hostile bytes cost much only sometimes, but then
# many at once; a pause of the garbage collector, which looks alike, is forgotten after 0.3 MB.
FORGETTING = 0.99


class ReadTurn:
    """The size of a connection's next read, at most `most_bytes`; does not read a clock."""

    def __init__(self, most_bytes: int) -> None:
        self.size_bytes = min(FIRST_READ_BYTES, most_bytes)
        self._most_bytes = most_bytes
        self._price_s = 0.0

    def note_quiet(self) -> None:
        """Learn that less came than is worth measuring."""
        self.size_bytes = min(self.size_bytes, FIRST_READ_BYTES)

    def note_cost(self, read_bytes: int, used_s: float) -> None:
        """Learn what a read has cost, in seconds of CPU."""
        price_s = self._price_s = max(used_s / read_bytes, self._price_s * FORGETTING)
        size_bytes = min(2 * self.size_bytes, self._most_bytes)
        if size_bytes * price_s > TURN_S:
            size_bytes = max(int(TURN_S / price_s), MIN_READ_BYTES)
        self.size_bytes = size_bytes
