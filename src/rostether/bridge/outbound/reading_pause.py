"""Pauses reading from a board while a queue behind the bridge is full, so that the board waits."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from rostether.transports.transport import Transport


class ReadingPause:
    """Pauses one transport until all `wait` functions have ended; calls `on_failed` if one of them raised."""

    def __init__(self, transport: Transport, on_failed: Callable[[Exception], None]) -> None:
        self._transport = transport
        self._on_failed = on_failed
        self._waits: list[Callable[[], Awaitable[object]]] = []
        self._draining: asyncio.Task[None] | None = None

    def pause_until(self, wait: Callable[[], Awaitable[object]]) -> bool:
        """Read nothing until `wait()` ends; return False if the transport cannot pause."""
        if not self._transport.can_pause:
            return False
        self._waits.append(wait)
        if self._draining is None:
            self._transport.pause_reading()
            self._draining = asyncio.get_running_loop().create_task(self._drain())
        return True

    def close(self) -> None:
        """Cancel all waits."""
        if self._draining is not None:
            self._draining.cancel()

    async def _drain(self) -> None:
        try:
            while self._waits:
                waits, self._waits = self._waits, []
                for outcome in await asyncio.gather(*(wait() for wait in waits), return_exceptions=True):
                    if isinstance(outcome, Exception):
                        self._on_failed(outcome)
        finally:
            self._draining = None
            self._transport.resume_reading()
