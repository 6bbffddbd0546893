"""A receiver that records the events of a transport, and lets a test wait for them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import TransportError
from rostether.transports.transport import Transport

WAIT_LIMIT_S = 60.0


class Recorder:
    def __init__(self) -> None:
        self.data = bytearray()
        self.chunks: list[bytes] = []
        self.losses: list[TransportError | None] = []
        self.write_pauses: list[bool] = []
        self._changed = asyncio.Event()

    def data_received(self, data: bytes) -> None:
        self.chunks.append(data)
        self.data += data
        self._changed.set()

    def connection_lost(self, error: TransportError | None) -> None:
        self.losses.append(error)
        self._changed.set()

    def pause_writing(self) -> None:
        self.write_pauses.append(True)
        self._changed.set()

    def resume_writing(self) -> None:
        self.write_pauses.append(False)
        self._changed.set()

    async def until(self, condition: Callable[[Recorder], bool]) -> None:
        async with asyncio.timeout(WAIT_LIMIT_S):
            while not condition(self):
                self._changed.clear()
                await self._changed.wait()

    async def until_received(self, data: bytes) -> None:
        await self.until(lambda seen: len(seen.data) >= len(data))
        assert bytes(self.data) == data

    async def until_lost(self) -> TransportError | None:
        await self.until(lambda seen: bool(seen.losses))
        return self.losses[0]


class Arrivals:
    """The transports that a listener announced."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[Transport] = asyncio.Queue()
        self.count = 0

    def __call__(self, transport: Transport) -> None:
        self.count += 1
        self._queue.put_nowait(transport)

    async def next(self) -> Transport:
        async with asyncio.timeout(WAIT_LIMIT_S):
            return await self._queue.get()

    async def next_started(self) -> tuple[Transport, Recorder]:
        transport, recorder = await self.next(), Recorder()
        transport.start(recorder)
        return transport, recorder
