"""The messages to one Foxglove client: responses in order, and messages of topics.

Messages of topics bypass the WebSocket library (see `data_outlet.py`).
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Protocol

from rostether.gateways.foxglove.data_outlet import DataOutlet
from rostether.gateways.foxglove.settings import FoxgloveLimits
from rostether.gateways.websocket.connection import Connection

# 50 ms of a fast network; further messages wait in queues where they can be dropped.
HIGH_WATER_BYTES = 1 << 20

# A client that reads fewer bytes of a large answer in this time is disconnected: the answer occupies memory
# for which other clients wait.
_LARGE_STEP_BYTES = 128 << 10
_LARGE_STEP_S = 20.0


class LineUser(Protocol):
    """Receives the events of one connection."""

    def received(self, message: str | bytes) -> None:
        """A complete message arrived."""

    def dropped(self, count: int) -> None:
        """This number of further messages was lost because the client reads slowly."""

    def closed(self) -> None:
        """The connection has ended."""


class Line:
    """The user of one connection; `user` is set by its creator."""

    user: LineUser

    def __init__(self, connection: Connection, limits: FoxgloveLimits) -> None:
        self._connection = connection
        self._limits = limits
        self._data = DataOutlet(
            limits.waiting_bytes, connection.write, lambda count: self.user.dropped(count)
        )
        self._large_turn = asyncio.Lock()
        self._large_bytes = 0

    # Events of the connection.

    def received(self, message: str | bytes) -> None:
        """Pass a message on."""
        self.user.received(message)

    def paused(self) -> None:
        """Keep messages of topics waiting."""
        self._data.pause()

    def resumed(self) -> None:
        """Send the waiting messages."""
        self._large_bytes = 0
        self._data.resume()

    def closed(self) -> None:
        """Send nothing more."""
        self._data.end()
        self.user.closed()

    # Calls from the client.

    @property
    def peer(self) -> str:
        """The client's address as text."""
        return self._connection.peer

    def pause_reading(self) -> None:
        """Stop reading, so that the client waits."""
        self._connection.pause_reading()

    def resume_reading(self) -> None:
        """Read again."""
        self._connection.resume_reading()

    def send(self, message: str | bytes) -> None:
        """Send an answer or an announcement; a client that does not read them is disconnected."""
        # The collected messages are older: send them first.
        self._data.flush()
        self._connection.send(message)
        if self._connection.unsent_bytes > self._limits.control_bytes + HIGH_WATER_BYTES + self._large_bytes:
            self.abort()

    async def send_large(self, message: bytes) -> None:
        """Send an answer of any size, and wait until the client has read most of it.

        A client that reads almost nothing is disconnected.
        """
        async with self._large_turn:
            await self._wait_for_room()
            self._large_bytes = len(message)
            self.send(message)
            await self._wait_for_room()

    def send_data(self, subscription_id: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Send messages of a topic, or queue them."""
        self._data.send(subscription_id, time_ns, payloads)

    def forget(self, subscription_id: int) -> None:
        """Discard the waiting messages of a subscription that has ended."""
        self._data.forget(subscription_id)

    def close(self, code: int, reason: str) -> None:
        """End the connection in order."""
        self._data.flush()
        self._data.end()
        self._connection.close(code, reason)

    def abort(self) -> None:
        """End the connection at once."""
        self._data.end()
        self._connection.abort()

    # Internal methods.

    async def _wait_for_room(self) -> None:
        while not self._connection.has_room.is_set():
            before = self._connection.unsent_bytes
            try:
                await asyncio.wait_for(self._connection.has_room.wait(), _LARGE_STEP_S)
            except TimeoutError:
                if self._connection.unsent_bytes > before - _LARGE_STEP_BYTES:
                    self.abort()
                    return
