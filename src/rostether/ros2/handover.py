"""Passes items from threads of a ROS 2 middleware to the event loop, in batches, through a bounded queue."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

_Item = TypeVar("_Item")

# The items passed on in one turn of the event loop: with 10 µs each, a flood blocks it for 10 ms.
MAX_BATCH = 1000
# Several images or maps in one turn would block it for 100 ms.
MAX_BATCH_BYTES = 1 << 20


def loss_text(topic: str) -> str:
    """Return the warning about dropped messages of a topic."""
    return (
        f"messages of {topic} arrive faster than this node handles them, and the oldest are dropped; publish "
        "them less often"
    )


class Handover(Generic[_Item]):
    """Passes items on in order; beyond `limit` (bytes, or items of size 1), the oldest are dropped.

    `put` may be called in any thread, all other methods only in the event loop. The newest item is always
    kept.
    """

    def __init__(self, deliver: Callable[[list[_Item]], None], *, limit: int) -> None:
        self.dropped_count = 0
        self._deliver = deliver
        self._limit = limit
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._queue: deque[tuple[_Item, int]] = deque()
        self._size = 0
        self._is_scheduled = False
        self._is_paused = False
        self._is_closed = False

    def put(self, item: _Item, size: int = 1) -> None:
        """Queue an item, whose `size` counts against the limit."""
        with self._lock:
            if self._is_closed:
                return
            self._queue.append((item, size))
            self._size += size
            while self._size > self._limit and len(self._queue) > 1:
                self._size -= self._queue.popleft()[1]
                self.dropped_count += 1
            if self._is_scheduled or self._is_paused:
                return
            self._is_scheduled = True
            try:
                self._loop.call_soon_threadsafe(self._run)
            except RuntimeError:
                self._is_closed = True  # The loop has ended before the middleware.

    def pause(self) -> None:
        """Keep new items until `resume`."""
        with self._lock:
            self._is_paused = True

    def resume(self) -> None:
        """Pass on the kept items, and continue."""
        with self._lock:
            self._is_paused = False
            if not self._is_scheduled and self._queue:
                self._is_scheduled = True
                self._loop.call_soon(self._run)

    def close(self) -> None:
        """Stop passing items on."""
        with self._lock:
            self._is_closed = True
            self._queue.clear()

    def _run(self) -> None:
        with self._lock:
            self._is_scheduled = False
            if self._is_paused or self._is_closed or not self._queue:
                return
            batch: list[_Item] = []
            batch_size = 0
            while self._queue and len(batch) < MAX_BATCH and batch_size < MAX_BATCH_BYTES:
                item, size = self._queue.popleft()
                batch.append(item)
                batch_size += size
            self._size -= batch_size
            if self._queue:
                self._is_scheduled = True
                self._loop.call_soon(self._run)
        self._deliver(batch)
