"""The process's memory: limits the objects that the garbage collector inspects, and releases free pages.

A full garbage collection inspects every object. With 1,000 boards it takes 0.3 s, and stops all messages.
"""

from __future__ import annotations

import asyncio
import gc

# A full collection of the objects of that many boards takes less than 10 ms.
FEW_BOARDS = 30
# Boards that connect one after the other are followed by one freeze.
FREEZE_AFTER_S = 0.5
# Boards that leave one after the other are followed by one release of memory.
RELEASE_AFTER_S = 2.0
# A full collection stops all messages: boards that connect and leave all the time must cause only a few.
# Python's own collections free the objects of these boards until then, because no more objects are exempted.
COLLECT_PERIOD_S = 10.0
# As in Python's own rule for full collections: garbage may become a quarter of the objects in use.
GARBAGE_PART = 4


class BoardObjects:
    """Exempts the objects of connected boards from full collections, until many of the boards have left."""

    def __init__(self) -> None:
        self._boards = 0
        self._left = 0
        self._collect_at_s = 0.0
        self._timer: asyncio.TimerHandle | None = None
        self._release_timer: asyncio.TimerHandle | None = None
        self._is_closed = False

    def connected(self) -> None:
        """Count a board that has connected."""
        self._boards += 1
        self._freeze_soon()

    def disconnected(self) -> None:
        """Count a board whose connection has ended."""
        self._boards -= 1
        self._left += 1
        self._freeze_soon()

    def node_left(self) -> None:
        """Count a node that has left the graph, usually some time after its board."""
        self._left += 1
        if self._release_timer is None and not self._is_closed:
            self._release_timer = asyncio.get_running_loop().call_later(RELEASE_AFTER_S, self._release)

    def close(self) -> None:
        """Let the collector inspect all objects again."""
        self._is_closed = True
        for timer in (self._timer, self._release_timer):
            if timer is not None:
                timer.cancel()
        gc.unfreeze()

    @property
    def _has_garbage(self) -> bool:
        return self._left > FEW_BOARDS and self._left * GARBAGE_PART > self._boards

    def _freeze_soon(self) -> None:
        if self._timer is None and (self._boards > FEW_BOARDS or self._has_garbage):
            self._timer = asyncio.get_running_loop().call_later(FREEZE_AFTER_S, self._freeze)

    def _freeze(self) -> None:
        self._timer = None
        if self._has_garbage:
            loop = asyncio.get_running_loop()
            if loop.time() < self._collect_at_s:
                self._timer = loop.call_at(self._collect_at_s, self._freeze)
                return
            self._collect()
        elif self._boards > FEW_BOARDS:
            gc.freeze()

    def _release(self) -> None:
        loop = asyncio.get_running_loop()
        if loop.time() < self._collect_at_s:
            self._release_timer = loop.call_at(self._collect_at_s, self._release)
            return
        self._release_timer = None
        if self._boards <= FEW_BOARDS or self._has_garbage:
            self._collect()
        else:
            gc.freeze()
        release_memory()

    def _collect(self) -> None:
        """Collect all garbage; exempt the remaining objects, also the program's, which exist permanently."""
        self._left = 0
        self._collect_at_s = asyncio.get_running_loop().time() + COLLECT_PERIOD_S
        gc.unfreeze()
        gc.collect()
        gc.freeze()


def release_memory() -> None:
    """Return unused pages to the system, in about 10 ms for 100 MB; without glibc, do nothing."""
    # Imported here, because few processes need it.
    import ctypes

    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):  # only glibc has it
        return
    trim(0)
