"""An event loop with a virtual clock, which jumps to the next timer instead of sleeping.

For tests without sockets or subprocesses: ten seconds of a recorded session pass in milliseconds.
"""

from __future__ import annotations

import asyncio
import selectors
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import Any, TypeVar

_T = TypeVar("_T")


class _JumpingSelector(selectors.DefaultSelector):
    def __init__(self) -> None:
        super().__init__()
        self.now_s = 1000.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(0)
        if not ready and timeout is not None:
            self.now_s += max(timeout, 0.0)
        assert ready or timeout is not None, "the test waits for something that never comes"
        return ready


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """Its `time()` is the virtual clock."""

    def __init__(self) -> None:
        self._jumping = _JumpingSelector()
        super().__init__(self._jumping)

    def time(self) -> float:
        return self._jumping.now_s


def run(main: Coroutine[Any, Any, _T]) -> _T:
    """Run a coroutine to its end on a virtual clock."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(main)


def on_virtual_time(test: Callable[[], Coroutine[Any, Any, None]]) -> Callable[[], None]:
    """Run a test without fixtures on a virtual clock, so that short time limits do not expire on a busy
    machine.
    """

    @wraps(test)
    def run_test() -> None:
        run(test())

    return run_test
