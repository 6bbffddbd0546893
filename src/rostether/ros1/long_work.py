"""Runs long work of a server in slices, so that other clients are answered in the meantime."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from time import monotonic

# Each piece of long work holds documents of a few MB; each adds one slice to a round of the event loop.
RUNNING_AT_ONCE = 4
# All slices of a round together stay below 50 ms.
SLICE_S = 0.004


async def run_in_slices(steps: Iterator[None]) -> None:
    """Run all `steps`, with a turn of the event loop after each slice."""
    due_s = monotonic() + SLICE_S
    for _ in steps:
        if monotonic() >= due_s:
            await asyncio.sleep(0)
            due_s = monotonic() + SLICE_S


def run_at_once(steps: Iterator[None]) -> None:
    """Run all `steps` without yielding to other tasks."""
    for _ in steps:
        pass
