"""Decides from pings and sent data whether a client is still connected."""

from __future__ import annotations


class PingWatch:
    """Counts unanswered pings; beyond `allowed`, a client that reads no data has disconnected."""

    def __init__(self, allowed: int) -> None:
        self._allowed = allowed
        self._unanswered = 0
        self._unsent_bytes = 0

    def received(self) -> None:
        """Record a frame of the client: it counts as the answer to all pings."""
        self._unanswered = 0

    def is_lost(self, unsent_bytes: int, *, is_reading: bool) -> bool:
        """Return whether the client has disconnected; if not, count the ping that is sent next."""
        has_read = unsent_bytes != self._unsent_bytes
        self._unsent_bytes = unsent_bytes
        # A client that still reads is alive, even if its pong is late. The pong of a paused client cannot be
        # read here.
        if self._unanswered >= self._allowed and is_reading and not has_read:
            return True
        self._unanswered += 1
        return False
