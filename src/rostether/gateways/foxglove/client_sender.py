"""The messages to one Foxglove client: responses in order, and messages of topics.

Messages of topics bypass the WebSocket library (see `data_outlet.py`).
"""

from __future__ import annotations

import asyncio
from typing import Protocol

from rostether.gateways.foxglove.data_outlet import DataOutlet
from rostether.gateways.foxglove.settings import FoxgloveLimits
from rostether.gateways.websocket.connection import Connection

# A client that reads fewer bytes of a large answer in this time is disconnected: the answer occupies memory
# for which other clients wait.
_LARGE_STEP_BYTES = 128 << 10
_LARGE_STEP_S = 20.0


class SenderUser(Protocol):
    """Receives the events of one connection."""

    def received(self, message: str | bytes) -> None:
        """Handle a complete message."""

    def dropped(self, count: int) -> None:
        """Handle the loss of `count` messages of topics, because the client reads slowly."""

    def closed(self) -> None:
        """Handle the end of the connection."""


class ClientSender:
    """Sends responses to one client, and passes its events to `user`, which the creator must set.

    `data` sends the messages of topics.
    """

    user: SenderUser

    def __init__(self, connection: Connection, limits: FoxgloveLimits) -> None:
        self.connection = connection
        self._limits = limits
        self.data = DataOutlet(limits.waiting_bytes, connection.write, lambda count: self.user.dropped(count))
        self._large_lock = asyncio.Lock()
        self._large_bytes = 0

    # Events of the connection.

    def received(self, message: str | bytes) -> None:
        """Pass a message on."""
        self.user.received(message)

    def paused(self) -> None:
        """Keep messages of topics waiting."""
        self.data.pause()

    def resumed(self) -> None:
        """Send the waiting messages."""
        self._large_bytes = 0
        self.data.resume()

    def closed(self) -> None:
        """Stop sending."""
        self.data.end()
        self.user.closed()

    # Calls from the client.

    def send(self, message: str | bytes) -> None:
        """Send an answer or an announcement; a client that does not read them is disconnected."""
        # The collected messages are older: send them first.
        self.data.flush()
        self.connection.send(message)
        limits = self._limits
        if self.connection.unsent_bytes > limits.control_bytes + limits.unsent_bytes + self._large_bytes:
            self.abort()

    async def send_large(self, message: bytes) -> None:
        """Send an answer of any size, and wait until the client has read most of it.

        A client that reads almost nothing is disconnected.
        """
        async with self._large_lock:
            await self._wait_for_room()
            self._large_bytes = len(message)
            self.send(message)
            await self._wait_for_room()

    def close(self, code: int, reason: str) -> None:
        """End the connection after a closing handshake."""
        self.data.flush()
        self.data.end()
        self.connection.close(code, reason)

    def abort(self) -> None:
        """End the connection immediately."""
        self.data.end()
        self.connection.abort()

    # Internal methods.

    async def _wait_for_room(self) -> None:
        while not self.connection.has_room.is_set():
            before = self.connection.unsent_bytes
            try:
                await asyncio.wait_for(self.connection.has_room.wait(), _LARGE_STEP_S)
            except TimeoutError:
                if self.connection.unsent_bytes > before - _LARGE_STEP_BYTES:
                    self.abort()
                    return
