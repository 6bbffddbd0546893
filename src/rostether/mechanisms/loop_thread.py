"""Asyncio loops in their own threads: for the program's threads, and for work that blocks its loop."""

from __future__ import annotations

import asyncio
import concurrent.futures
import os
import threading
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar

from rostether.errors import GraphError, RostetherError
from rostether.mechanisms.tasks import start_task

# A future cannot raise StopIteration, and would raise the CancelledError of threads as that of tasks, as if
# its caller was canceled.
_NOT_FOR_FUTURES = (StopIteration, concurrent.futures.CancelledError)

_T = TypeVar("_T")

# Users expect Ctrl-C to take effect within about this time.
_SHORT_WAIT_S = 0.5


class LoopThread:
    """Runs coroutines for other threads; its thread starts with the first call and never blocks the exit.

    `interrupted` makes the error of calls that `interrupt` ends. A forked process does not have the thread:
    there, all calls raise GraphError.
    """

    def __init__(self, interrupted: Callable[[], BaseException] = concurrent.futures.CancelledError) -> None:
        self._interrupted = interrupted
        # Reentrant: a signal may end the node while its main thread holds the lock.
        self._lock = threading.RLock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._process_id = 0
        self._waiting: set[concurrent.futures.Future[Any]] = set()
        self._tasks: set[asyncio.Task[Any]] = set()

    @property
    def is_lost(self) -> bool:
        """Whether this process was forked after the loop had started."""
        return self._loop is not None and self._process_id != os.getpid()

    def require_thread(self) -> None:
        """Raise GraphError in a forked process."""
        if self.is_lost:
            raise GraphError(
                "this process was forked, and cannot use the node of its parent; start it with "
                "multiprocessing.set_start_method('spawn'), and let it join the graph"
            )

    @property
    def loop(self) -> asyncio.AbstractEventLoop:
        """The running loop; its first use starts the thread. Raises GraphError in a forked process."""
        self.require_thread()
        with self._lock:
            if self._loop is None:
                self._process_id = os.getpid()
                ready = threading.Event()
                loop = self._loop = asyncio.new_event_loop()
                loop.call_soon(ready.set)
                threading.Thread(target=self._run, args=(loop,), name="rostether graph", daemon=True).start()
                ready.wait()
            return self._loop

    def call(self, coroutine: Coroutine[Any, Any, _T], *, timeout_s: float | None = None) -> _T:
        """Run a coroutine, and return its result or raise its error.

        Raises the error of `interrupted` after `interrupt`, TimeoutError after `timeout_s`, GraphError in a
        forked process.
        """
        try:
            loop = self.loop
        except GraphError:
            coroutine.close()
            raise
        with self._lock:
            future = asyncio.run_coroutine_threadsafe(coroutine, loop)
            self._waiting.add(future)
        try:
            return _result(future, timeout_s)
        except concurrent.futures.CancelledError:
            raise self._interrupted() from None
        except (RostetherError, TimeoutError) as error:
            # The text explains the error, so the traceback has only the program's own frames.
            future.cancel()
            raise error.with_traceback(None)  # noqa: B904 - it is the same error
        except BaseException:
            future.cancel()
            raise
        finally:
            self._waiting.discard(future)

    def post(self, function: Callable[..., object], *arguments: Any) -> None:
        """Schedule a function in the loop, without waiting for its result."""
        self.loop.call_soon_threadsafe(function, *arguments)

    def start(self, coroutine: Coroutine[Any, Any, object]) -> None:
        """Start a coroutine in the loop, without waiting for its result."""
        self.post(start_task, self._tasks, coroutine)

    def interrupt(self) -> None:
        """Wake every thread that waits in `call`."""
        with self._lock:
            waiting = list(self._waiting)
        for future in waiting:
            future.cancel()

    def _run(self, loop: asyncio.AbstractEventLoop) -> None:
        asyncio.set_event_loop(loop)
        loop.run_forever()


def _result(future: concurrent.futures.Future[_T], timeout_s: float | None) -> _T:
    """Wait in short steps: Ctrl-C just before a step, or during it on Windows, takes effect after it."""
    deadline_s = float("inf") if timeout_s is None else time.monotonic() + timeout_s
    while True:
        left_s = deadline_s - time.monotonic()
        try:
            return future.result(max(0.0, min(left_s, _SHORT_WAIT_S)))
        except TimeoutError:
            if future.done():
                # The coroutine raised this error itself, or it ended just after the wait.
                return future.result()
            if left_s <= _SHORT_WAIT_S:
                raise


async def run_in_thread(function: Callable[[], _T]) -> _T:
    """Run a function that may block, in a new thread, and wait for its result.

    Each call has its own thread: handlers may wait for each other, and would block a pool.
    """
    outcome: concurrent.futures.Future[_T] = concurrent.futures.Future()
    # If the caller is canceled, the function continues.
    outcome.set_running_or_notify_cancel()

    def run() -> None:
        try:
            outcome.set_result(function())
        except BaseException as error:  # noqa: BLE001 - sys.exit() in a handler ends its thread, not our loop
            is_fit = isinstance(error, Exception) and not isinstance(error, _NOT_FOR_FUTURES)
            outcome.set_exception(error if is_fit else RuntimeError(repr(error)))

    threading.Thread(target=run, daemon=True).start()
    return await asyncio.wrap_future(outcome)


async def in_own_loop(work: Callable[[], Coroutine[Any, Any, _T]]) -> _T:
    """Await `work()` on an event loop in its own thread; return its result or raise its error.

    When the caller is canceled, so is the work, and the caller waits until it has ended.
    """
    outer = asyncio.get_running_loop()
    started: asyncio.Future[Callable[[], object]] = outer.create_future()

    async def run() -> _T:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        assert task is not None
        outer.call_soon_threadsafe(started.set_result, partial(loop.call_soon_threadsafe, task.cancel))
        return await work()

    thread = asyncio.ensure_future(asyncio.to_thread(asyncio.run, run()))
    try:
        return await asyncio.shield(thread)
    except asyncio.CancelledError:
        cancel = await started
        with suppress(RuntimeError):  # it has just ended by itself
            cancel()
        # The caller already gets its end as a cancellation.
        await asyncio.gather(thread, return_exceptions=True)
        raise
