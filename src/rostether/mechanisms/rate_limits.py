"""Limits of rates: of events, of lines that remote peers can cause, and of repeated lines."""

from __future__ import annotations

from collections import OrderedDict

# Scanners, boards in a reconnect loop and broken lines repeat many times a second; one line of each kind in
# this time is enough.
PERIOD_S = 10.0

# The lines of all kinds in this time: a user can read two lines a second.
MAX_LINES = 20

# Kinds may contain names that a peer chose; the oldest is forgotten, so that no peer can fill the memory.
MAX_KINDS = 256


class TokenBucket:
    """Admits `per_s` events a second, and up to `burst` at once after a pause."""

    def __init__(self, per_s: float, burst: float, now_s: float = 0.0) -> None:
        self._per_s = per_s
        self._burst = burst
        self._room = burst
        self._counted_s = now_s

    def room(self, now_s: float) -> float:
        """Return how many events may pass now."""
        self._room = min(self._room + (now_s - self._counted_s) * self._per_s, self._burst)
        self._counted_s = now_s
        return self._room

    def admit(self, count: int, now_s: float) -> int:
        """Count events that pass now; return how many of `count` may."""
        admitted = min(count, int(self.room(now_s)))
        self._room -= admitted
        return admitted


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


class RepeatLimiter:
    """Admits a line of a kind if none was admitted for `PERIOD_S`, and counts those that it does not admit.

    With `by_episode`, a line that is not admitted starts the period again: a fault is reported again only
    after it has not appeared for that time.
    """

    def __init__(self, *, by_episode: bool = False) -> None:
        self._by_episode = by_episode
        # {kind: (start of the period, omitted lines)}
        self._kinds: OrderedDict[str, tuple[float, int]] = OrderedDict()

    def admit(self, kind: str, now_s: float, *, count: int = 1) -> int | None:
        """Return how many lines of the kind were omitted since the last one, None to omit this one.

        `count` is the number of events in the line.
        """
        began_s, omitted_count = self._kinds.get(kind, (float("-inf"), 0))
        if now_s - began_s < PERIOD_S:
            self._kinds[kind] = now_s if self._by_episode else began_s, omitted_count + count
            return None
        self._kinds[kind] = now_s, 0
        self._kinds.move_to_end(kind)
        if len(self._kinds) > MAX_KINDS:
            self._kinds.popitem(last=False)
        return omitted_count

    def forget(self, kind: str) -> None:
        """Admit the next line of a kind."""
        self._kinds.pop(kind, None)
