"""Reports refused peers at a limited rate, so that they cannot fill the log."""

from __future__ import annotations

import logging
from collections.abc import Callable

from rostether.mechanisms.rate_limits import RepeatLimiter

_LOG = logging.getLogger(__name__)


class RefusalLog:
    """Counts refused peers, and logs at most one line every ten seconds: they cannot fill the log."""

    def __init__(self, listener: str, clock: Callable[[], float]) -> None:
        self.count = 0
        self._listener = listener
        self._clock = clock
        self._lines = RepeatLimiter()

    def refuse(self, peer: str, reason: str) -> None:
        """Count a refused peer, and log it if the rate permits."""
        self.count += 1
        omitted_count = self._lines.admit("refused", self._clock())
        if omitted_count is None:
            return
        more = f" ({omitted_count} more since the last such line)" if omitted_count else ""
        _LOG.warning("%s refused %s: %s%s", self._listener, peer, reason, more)
