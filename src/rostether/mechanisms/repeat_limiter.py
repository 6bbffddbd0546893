"""Limits repeated lines: one line of each kind per period, and a count of the others."""

from __future__ import annotations

from collections import OrderedDict

# Scanners, boards in a reconnect loop and broken lines repeat many times a second; one line in this time is
# enough.
PERIOD_S = 10.0
# Kinds may contain names that a peer chose; the oldest is forgotten, so that no peer can fill the memory.
MAX_KINDS = 256


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
