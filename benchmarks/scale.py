"""1 to 1,000 boards in one process, each at 10 Hz: lost messages, delays, memory."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.crowd import Crowd, crowd

DEVICES = (1, 10, 100, 300, 1000)
RATE_HZ = 10
SECONDS = 20


def scales() -> Iterator[tuple[int, Crowd]]:
    """Measure each number of boards in a separate process."""
    for devices in DEVICES:
        yield devices, crowd(devices, RATE_HZ, SECONDS, floods=False)
