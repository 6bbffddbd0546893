"""Reports refused connections of a gateway at a limited rate."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.mechanisms.text import fold_line

# A page that may not connect retries every second; one log line in this time is enough.
QUIET_S = 10.0

# Reasons logged in that time: a refused client may cause a different one with each connection.
MAX_REASONS = 5


class Refusals:
    """Reports each reason once in `QUIET_S`, at most MAX_REASONS of them, and counts the omitted reports."""

    def __init__(self, report: Callable[[str], None]) -> None:
        self._report = report
        self._reported: set[str] = set()
        self._reported_until_s = 0.0
        self._omitted_count = 0

    def report(self, peer: str, reason: str) -> None:
        """Report a refused connection by its address, unless the rate limit of reports is reached."""
        now_s = asyncio.get_running_loop().time()
        if now_s >= self._reported_until_s:
            self._reported.clear()
            self._reported_until_s = now_s + QUIET_S
        if reason in self._reported or len(self._reported) >= MAX_REASONS:
            self._omitted_count += 1
            return
        self._reported.add(reason)
        more = f" ({self._omitted_count} more since the last such line)" if self._omitted_count else ""
        self._report(f"refused {peer}: {fold_line(reason)}{more}")
        self._omitted_count = 0
