"""Saying that peers are refused, without letting them write our log."""

from __future__ import annotations

import logging
from collections.abc import Callable

_LOG = logging.getLogger(__name__)
# A scanner or a board in a reconnect loop comes many times a second; one line now and then tells as much.
_QUIET_S = 10.0


class RefusalLog:
    """Counts refused peers and logs at most one line each ten seconds."""

    def __init__(self, listener: str, clock: Callable[[], float]) -> None:
        self.count = 0
        self._listener = listener
        self._clock = clock
        self._quiet_until_s = float("-inf")
        self._unsaid = 0

    def refuse(self, peer: str, reason: str) -> None:
        """Count one refused peer, and log it unless one was logged just now."""
        self.count += 1
        now_s = self._clock()
        if now_s < self._quiet_until_s:
            self._unsaid += 1
            return
        more = f" ({self._unsaid} more since the last such line)" if self._unsaid else ""
        _LOG.warning("%s refused %s: %s%s", self._listener, peer, reason, more)
        self._quiet_until_s = now_s + _QUIET_S
        self._unsaid = 0
