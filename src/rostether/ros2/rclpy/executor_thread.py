"""rclpy's executor in its own thread, and the calls between that thread and the event loop.

rclpy blocks while it waits, so it cannot run in an event loop. Everything that creates, changes or destroys
the executor's entities runs in its thread (`run`), so that there are no races. Callbacks pass their results
to the event loop (`call_in_loop`).
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from rostether.errors import GraphError
from rostether.ros2.rclpy.installation import load_rclpy

# The time limit for the end of the thread; its longest task, creating a node, takes much less.
MAX_JOIN_S = 5.0

_Result = TypeVar("_Result")
_log = logging.getLogger("rostether.ros2")


class NoAnswerError(Exception):
    """Raised in a service's callback to leave a request without an answer; it is not logged."""


class ExecutorThread:
    """Spins one node of a context. Create it in the event loop that receives the results."""

    def __init__(self, context: Any) -> None:
        self._loop = asyncio.get_running_loop()
        self._context = context
        self.executor = load_rclpy().executors.SingleThreadedExecutor(context=context)
        self._is_stopping = False
        self._thread = threading.Thread(target=self._spin, name="rclpy executor", daemon=True)
        self._thread.start()

    async def run(self, function: Callable[[], _Result]) -> _Result:
        """Run a function in the thread; return its result. Raises its error, and GraphError after `stop`."""
        if self._is_stopping:
            raise GraphError("rclpy has been shut down; open it again")
        future: asyncio.Future[_Result] = self._loop.create_future()

        def work() -> None:
            try:
                result = function()
            except Exception as error:  # noqa: BLE001 - the caller gets it
                self.call_in_loop(_set_exception, future, error)
            else:
                self.call_in_loop(set_result, future, result)

        self.executor.create_task(work)
        return await future

    def submit(self, function: Callable[[], object]) -> None:
        """Run a function in the thread soon; an exception is logged. After `stop`, do nothing."""
        if not self._is_stopping:
            self.executor.create_task(function)

    def call_in_loop(self, callback: Callable[..., object], *args: object) -> None:
        """Call back in the event loop, unless the loop has ended."""
        try:
            self._loop.call_soon_threadsafe(callback, *args)
        except RuntimeError:
            _log.debug("the event loop has ended before %s", callback)

    async def stop(self) -> None:
        """End the thread. Idempotent."""
        if self._is_stopping:
            return
        self._is_stopping = True
        self.executor.create_task(lambda: None)
        await asyncio.to_thread(self._thread.join, MAX_JOIN_S)
        self.executor.shutdown()

    def _spin(self) -> None:
        while not self._is_stopping and self._context.ok():
            try:
                self.executor.spin_once()
            except NoAnswerError:
                pass
            except Exception as error:  # noqa: BLE001 - one callback must not end all others
                if self._context.ok() and not self._is_stopping:
                    _log.error("a callback of rclpy failed: %s: %s", type(error).__name__, error)
                    _log.debug("traceback of this failure", exc_info=error)


def set_result(future: asyncio.Future[_Result], result: _Result) -> None:
    """Set the result, unless the waiting task was canceled."""
    if not future.done():
        future.set_result(result)


def _set_exception(future: asyncio.Future[_Result], error: Exception) -> None:
    if not future.done():
        future.set_exception(error)
