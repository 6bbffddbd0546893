"""A number of lines in a period, for lines that remote peers can cause."""

from __future__ import annotations

# A user can read two lines a second.
MAX_LINES = 20
PERIOD_S = 10.0


class LineBudget:
    """Admits MAX_LINES lines in PERIOD_S, and counts those that it does not admit."""

    def __init__(self) -> None:
        self._began_s = float("-inf")
        self._admitted_count = 0
        self._omitted_count = 0

    def admit(self, now_s: float) -> int | None:
        """Return how many lines were omitted before this one since the last report, None to omit this one."""
        omitted_count = 0
        if now_s - self._began_s >= PERIOD_S:
            omitted_count = self._omitted_count
            self._began_s, self._admitted_count, self._omitted_count = now_s, 0, 0
        if self._admitted_count == MAX_LINES:
            self._omitted_count += 1
            return None
        self._admitted_count += 1
        return omitted_count
