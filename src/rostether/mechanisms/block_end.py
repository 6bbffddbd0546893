"""Ends objects with a block of code: closes them, or cancels a task beside it."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Awaitable, Coroutine
from contextlib import asynccontextmanager
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from rostether.mechanisms.tasks import cancel_all


class Closable(Protocol):
    """Something with an asynchronous `close`."""

    def close(self) -> Awaitable[object]:
        """Close it."""


class BlockClosable(ABC):
    """The base of classes that `async with` closes at the end of its block."""

    @abstractmethod
    async def close(self) -> None:
        """Close it."""

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()


T = TypeVar("T", bound=Closable)


@asynccontextmanager
async def closed_at_end(opened: T) -> AsyncIterator[T]:
    """Close `opened` at the end of the block: contextlib.closing for an asynchronous `close`."""
    try:
        yield opened
    finally:
        await opened.close()


@asynccontextmanager
async def task_beside(work: Coroutine[Any, Any, object]) -> AsyncIterator[asyncio.Task[object]]:
    """Run `work` during the block; at its end, cancel it and wait for its end. Its errors are ignored."""
    task = asyncio.get_running_loop().create_task(work)
    try:
        yield task
    finally:
        await cancel_all(task)
