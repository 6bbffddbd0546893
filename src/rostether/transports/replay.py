"""Plays the devices' side of a capture: each of its links becomes a transport."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from rostether.errors import ConfigError, TransportError
from rostether.transports.capture import Capture, Chunk, LinkClosed, LinkOpened
from rostether.transports.memory import MemoryTransport, memory_pair
from rostether.transports.transport import Transport

# As many as a TCP listener accepts from one host: a capture is untrusted, and each link becomes a session.
MAX_LINKS = 128

# How often the replay checks whether the host has received a chunk.
_RECEIVED_POLL_S = 0.001


class CaptureListener:
    """A listener whose peers are the links of a capture; they connect when it plays.

    Bytes from the host are ignored. `speed` is the factor of the recorded speed; None: without pauses.
    `settle()` is called after each chunk; it returns the delay of the following chunks, in seconds.
    """

    def __init__(
        self,
        capture: Capture,
        on_transport: Callable[[Transport], None],
        *,
        speed: float | None = 1.0,
        settle: Callable[[], Awaitable[float]] | None = None,
    ) -> None:
        self.address = str(capture.path)
        self.played_bytes = 0
        self._capture = capture
        self._on_transport = on_transport
        self._speed = speed
        self._settle = settle
        self._boards: dict[int, _PlayedBoard] = {}

    async def play(self) -> None:
        """Play the capture to its end and close. Raises ConfigError if it is not a capture."""
        loop = asyncio.get_running_loop()
        began_s = loop.time()
        try:
            for entry in self._capture.entries():
                if self._speed is not None:
                    await asyncio.sleep(began_s + entry.time_s / self._speed - loop.time())
                match entry:
                    case Chunk(link=link, from_device=True, data=data):
                        board = self._boards.get(link) or self._plug_in(link)
                        board.transport.write(data)
                        self.played_bytes += len(data)
                        await board.has_room.wait()
                        await board.wait_until_read()
                        if self._settle is not None:
                            began_s += await self._settle()
                    case LinkOpened(link=link):
                        self._unplug(link)
                        self._plug_in(link)
                    case LinkClosed(link=link):
                        self._unplug(link)
        finally:
            await self.close()

    async def close(self) -> None:
        """Close all links. Idempotent."""
        for link in list(self._boards):
            self._unplug(link)

    def _plug_in(self, link: int) -> _PlayedBoard:
        if len(self._boards) >= MAX_LINKS:
            raise ConfigError(f"{self.address} has more than {MAX_LINKS} links at once; record fewer boards")
        ours, theirs = memory_pair(names=(f"capture {self.address}", "host"))
        board = self._boards[link] = _PlayedBoard(ours)
        self._on_transport(theirs)
        return board

    def _unplug(self, link: int) -> None:
        board = self._boards.pop(link, None)
        if board is not None:
            board.transport.close()


class _PlayedBoard:
    """A board's end of one link; it ignores the host."""

    def __init__(self, transport: MemoryTransport) -> None:
        self.transport = transport
        self.has_room = asyncio.Event()
        self.has_room.set()
        self._is_gone = False
        transport.start(self)

    async def wait_until_read(self) -> None:
        """Wait until the host has received all bytes, which it does after its node has joined the graph."""
        await asyncio.sleep(0)
        # The transport does not report a delivery; a check is cheap.
        while self.transport.write_buffer_bytes and not self._is_gone:  # noqa: ASYNC110
            await asyncio.sleep(_RECEIVED_POLL_S)

    def data_received(self, data: bytes) -> None:
        """Ignore received bytes."""

    def connection_lost(self, _error: TransportError | None) -> None:
        """Stop the replay: the host closed the link."""
        self._is_gone = True
        self.has_room.set()

    def pause_writing(self) -> None:
        """Wait: the host's buffer is full."""
        self.has_room.clear()

    def resume_writing(self) -> None:
        """Continue: the host's buffer has room."""
        self.has_room.set()
