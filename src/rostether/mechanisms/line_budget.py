"""A number of lines in a period, for lines that remote peers can cause."""

from __future__ import annotations


class LineBudget:
    """Admits `count` lines in `period_s`, and counts those that it does not admit."""

    def __init__(self, count: int = 20, period_s: float = 10.0) -> None:
        self._count = count
        self._period_s = period_s
        self._began_s = float("-inf")
        self._admitted_count = 0
        self._omitted_count = 0

    def admit(self, now_s: float) -> int | None:
        """Return how many lines were omitted before this one since the last report, None to omit this one."""
        omitted_count = 0
        if now_s - self._began_s >= self._period_s:
            omitted_count = self._omitted_count
            self._began_s, self._admitted_count, self._omitted_count = now_s, 0, 0
        if self._admitted_count == self._count:
            self._omitted_count += 1
            return None
        self._admitted_count += 1
        return omitted_count
