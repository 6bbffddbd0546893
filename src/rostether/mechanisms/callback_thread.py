"""A thread that runs the callbacks of one source in order.

The thread begins with the first item, and ends IDLE_S after the last one: publishers that have disconnected
leave no threads behind.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

_T = TypeVar("_T")

# How long a thread waits for items before it ends; a new one costs a tenth of a millisecond.
IDLE_S = 5.0

# The limits at which the source stops and continues: a slow callback must not fill the memory.
HIGH_WATER_ITEMS = 1000
LOW_WATER_ITEMS = 100


class CallbackThread(Generic[_T]):
    """Passes items to `run`, which must not raise. Only the newest `limit` items wait (None: all).

    `on_full` gets True when more than HIGH_WATER_ITEMS wait, and False when LOW_WATER_ITEMS are left.
    """

    def __init__(
        self,
        name: str,
        run: Callable[[_T], object],
        *,
        limit: int | None = None,
        on_full: Callable[[bool], object] | None = None,
    ) -> None:
        self.limit = limit
        self._name = name
        self._run = run
        self._on_full = on_full
        self._items: deque[_T] = deque()
        self._wakeup = threading.Condition()
        self._is_alive = False
        self._is_full = False
        self._is_closed = False

    def put(self, items: Iterable[_T]) -> None:
        """Queue items. Never blocks."""
        with self._wakeup:
            if self._is_closed:
                return
            self._items.extend(items)
            while self.limit is not None and len(self._items) > self.limit:
                self._items.popleft()
            if not self._is_alive:
                self._is_alive = True
                threading.Thread(target=self._work, name=self._name, daemon=True).start()
            self._wakeup.notify()
            self._report_fill()

    @property
    def is_alive(self) -> bool:
        """Whether there is a thread now."""
        return self._is_alive

    def close(self) -> None:
        """End after the running callback."""
        with self._wakeup:
            self._is_closed = True
            self._items.clear()
            self._wakeup.notify()

    def _work(self) -> None:
        while True:
            with self._wakeup:
                while not self._items:
                    if self._is_closed or not self._wakeup.wait(IDLE_S):
                        if self._items:
                            continue
                        self._is_alive = False
                        return
                item = self._items.popleft()
                self._report_fill()
            self._run(item)

    def _report_fill(self) -> None:
        count = len(self._items)
        is_full = count > HIGH_WATER_ITEMS or (self._is_full and count > LOW_WATER_ITEMS)
        if is_full != self._is_full:
            self._is_full = is_full
            if self._on_full is not None:
                self._on_full(is_full)
