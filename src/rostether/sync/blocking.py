"""Makes blocking methods, for the program's threads, from the methods of objects in the event loop."""

from __future__ import annotations

import asyncio
import atexit
import logging
from collections.abc import Callable, Coroutine
from contextlib import AbstractAsyncContextManager
from functools import partial, wraps
from types import TracebackType
from typing import Any, Concatenate, Generic, ParamSpec, Self, TypeVar

from rostether.graph.callbacks import require_plain
from rostether.mechanisms.loop_thread import LoopThread, run_in_thread

P = ParamSpec("P")
T = TypeVar("T")
R = TypeVar("R")
Wrapped = TypeVar("Wrapped", covariant=True)

_LOG = logging.getLogger(__name__)

# One event loop serves all nodes and devices of the program.
LOOP = LoopThread()

# The time limit for leaving a graph: a program must end even if the master or peers do not answer.
CLOSE_TIMEOUT_S = 10.0

_ADVICE = "with rostether.sync, write a plain function"


class Blocking(Generic[Wrapped]):
    """Provides the methods of `wrapped`, an object of the event loop, as blocking methods."""

    def __init__(self, wrapped: Wrapped) -> None:
        self.wrapped = wrapped


def blocking(
    method: Callable[Concatenate[Wrapped, P], Coroutine[Any, Any, T]],
) -> Callable[Concatenate[Blocking[Wrapped], P], T]:
    """Return a method that runs a coroutine method in the loop and waits for its result."""

    @wraps(method)
    def call(self: Blocking[Wrapped], /, *args: P.args, **kwargs: P.kwargs) -> T:
        # The method is found by its name, because `method` may belong to a protocol.
        found: Callable[P, Coroutine[Any, Any, T]] = getattr(self.wrapped, method.__name__)
        return LOOP.call(found(*args, **kwargs))

    return call


def guarded(callback: Callable[[T], object]) -> Callable[[T], None]:
    """Return a function that calls a callback and logs its exceptions. Raises TypeError if it is async."""
    require_plain("callback", callback, _ADVICE)

    def call(item: T) -> None:
        try:
            callback(item)
        except Exception:  # noqa: BLE001 - it is the user's code
            _LOG.exception("the callback %s failed", getattr(callback, "__name__", callback))

    return call


def threaded(handler: Callable[[T], R]) -> Callable[[T], Coroutine[Any, Any, R]]:
    """Return a handler for the loop that runs `handler` in a new thread. Raises TypeError if it is async."""
    require_plain("handler", handler, _ADVICE)

    async def handle(request: T) -> R:
        return await run_in_thread(partial(handler, request))

    return handle


def in_loop(method: Callable[Concatenate[Wrapped, P], T]) -> Callable[Concatenate[Blocking[Wrapped], P], T]:
    """Return a method that runs a plain method in the loop and waits for its result."""

    @wraps(method)
    def call(self: Blocking[Wrapped], /, *args: P.args, **kwargs: P.kwargs) -> T:
        async def run() -> T:
            return method(self.wrapped, *args, **kwargs)

        return LOOP.call(run())

    return call


class OpenContext(Blocking[Wrapped]):
    """An object that an asynchronous context keeps open until `close`, or the end of the program."""

    def __init__(self, make_context: Callable[[], AbstractAsyncContextManager[Wrapped]]) -> None:
        super().__init__(LOOP.call(self._open(make_context)))
        self.is_closed = False
        atexit.register(self.close)

    async def _open(self, make_context: Callable[[], AbstractAsyncContextManager[Wrapped]]) -> Wrapped:
        opened: asyncio.Future[Wrapped] = asyncio.get_running_loop().create_future()
        self._leave = asyncio.Event()
        # One task opens and closes: a context must stay in its task.
        self._task = asyncio.create_task(self._hold(make_context, opened))
        try:
            return await asyncio.shield(opened)
        except asyncio.CancelledError:
            self._task.cancel()
            raise

    async def _hold(
        self,
        make_context: Callable[[], AbstractAsyncContextManager[Wrapped]],
        opened: asyncio.Future[Wrapped],
    ) -> None:
        try:
            async with make_context() as wrapped:
                opened.set_result(wrapped)
                await self._leave.wait()
        except Exception as error:
            if opened.done():
                raise
            opened.set_exception(error)

    async def _end(self) -> None:
        self._leave.set()
        await self._task

    def close(self) -> None:
        """End the object's context. Idempotent. Raises TimeoutError if it takes more than 10 s."""
        if not self.is_closed:
            self.is_closed = True
            atexit.unregister(self.close)
            # After a fork, the node belongs to the parent process, which continues to run it.
            if not LOOP.is_lost:
                LOOP.call(self._end(), timeout_s=CLOSE_TIMEOUT_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
