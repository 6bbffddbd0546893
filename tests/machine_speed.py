"""How much more processor time the same work takes beside other programs: caches and cores are shared."""

from __future__ import annotations

import statistics
import time

# The processor time of `_work` on a quiet machine. On a busy one it is up to three times as long.
QUIET_S = 0.0075


def slowness() -> float:
    """Return the factor by which this machine is slower now than a quiet one, at least 1."""
    return max(1.0, statistics.median(_work() for _ in range(9)) / QUIET_S)


def _work() -> float:
    began_s = time.thread_time()
    values = {f"key {number}": [number] for number in range(20_000)}
    values.clear()
    return time.thread_time() - began_s
