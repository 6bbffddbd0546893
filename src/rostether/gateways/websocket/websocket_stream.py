"""One WebSocket for a protocol that handles one message at a time."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator

from rostether.gateways.websocket.connection import Connection

# Messages read ahead from one client; beyond this, its socket fills and slows it down.
MAX_WAITING = 16


class WebSocketStream:
    """The user of a connection: an asynchronous iterator over received messages, and a sender that waits."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._messages: deque[str | bytes] = deque()
        self._is_closed = False
        self._is_paused = False
        self._wakeup = asyncio.Event()

    def received(self, message: str | bytes) -> None:
        """Queue a message."""
        self._messages.append(message)
        self._wakeup.set()
        if len(self._messages) >= MAX_WAITING and not self._is_paused:
            self._is_paused = True
            self._connection.pause_reading()

    def paused(self) -> None:
        """Do nothing: `send` waits."""

    def resumed(self) -> None:
        """Do nothing: `send` continues."""

    def closed(self) -> None:
        """End the stream after the received messages."""
        self._is_closed = True
        self._wakeup.set()

    async def receive(self) -> str | bytes | None:
        """Return the next message, None after the last."""
        while not self._messages:
            if self._is_closed:
                return None
            self._wakeup.clear()
            await self._wakeup.wait()
        message = self._messages.popleft()
        if self._is_paused and not self._messages:
            self._is_paused = False
            self._connection.resume_reading()
        return message

    async def __aiter__(self) -> AsyncIterator[str | bytes]:
        while (message := await self.receive()) is not None:
            yield message

    async def send(self, *messages: str | bytes) -> None:
        """Send messages with one system call, and wait until the client has read most of them."""
        self._connection.send(*messages)
        await self._connection.has_room.wait()

    def close(self, code: int, reason: str) -> None:
        """End the connection with a code of RFC 6455."""
        self._connection.close(code, reason)

    def abort(self) -> None:
        """End the connection immediately."""
        self._connection.abort()
