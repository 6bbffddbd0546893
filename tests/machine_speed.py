"""Measures how much more processor time the same work needs while other programs share caches and cores."""

from __future__ import annotations

import os
import statistics
import time

# The processor time of `_work` on a quiet machine. On a busy one it is up to three times as long.
QUIET_S = 0.0075


def slowness() -> float:
    """Return how much slower this machine is now than a quiet one; at least 2 while other tests run."""
    at_least = 2.0 if "PYTEST_XDIST_WORKER" in os.environ else 1.0
    return max(at_least, statistics.median(_work() for _ in range(9)) / QUIET_S)


def _work() -> float:
    began_s = time.thread_time()
    values = {f"key {number}": [number] for number in range(20_000)}
    values.clear()
    return time.thread_time() - began_s
