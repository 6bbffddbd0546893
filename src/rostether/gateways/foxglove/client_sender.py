"""The messages to one Foxglove client: responses in order, and messages of topics.

Messages of topics bypass the WebSocket library (see `data_outlet.py`).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.data_outlet import DataOutlet
from rostether.gateways.foxglove.server_messages import StatusLevel
from rostether.gateways.foxglove.settings import FoxgloveLimits
from rostether.gateways.websocket.connection import Connection
from rostether.mechanisms.tasks import occurs_within
from rostether.mechanisms.text import counted

# A client that reads fewer bytes of a large answer in this time is disconnected: the answer occupies memory
# for which other clients wait.
_LARGE_STEP_BYTES = 128 << 10
_LARGE_STEP_S = 20.0

_STATUS_ID = "slow-client"

# How often a client gets the number of lost messages.
_PERIOD_S = 5.0


class DroppedReport:
    """Counts lost messages; the status is removed after some time without losses."""

    def __init__(self, send: Callable[[str], None]) -> None:
        self._send = send
        self.count = 0
        self._reported = 0
        self._timer: asyncio.TimerHandle | None = None

    def add(self, count: int) -> None:
        """Count lost messages; they are reported now, or with the next report."""
        self.count += count
        if self._timer is None:
            self._report()

    def close(self) -> None:
        """Stop reporting."""
        if self._timer is not None:
            self._timer.cancel()

    def _report(self) -> None:
        self._timer = None
        if self.count == self._reported:
            self._send(replies.remove_status([_STATUS_ID]))
            return
        self._reported = self.count
        text = f"this client reads too slowly: {counted(self.count, 'message')} dropped so far"
        self._send(replies.status(StatusLevel.WARNING, text, _STATUS_ID))
        self._timer = asyncio.get_running_loop().call_later(_PERIOD_S, self._report)


class ClientSender:
    """Sends to one client; `data` sends the messages of topics. The client gets a report of lost messages."""

    def __init__(self, connection: Connection, limits: FoxgloveLimits) -> None:
        self.connection = connection
        self._limits = limits
        self._dropped = DroppedReport(self.send)
        self.data = DataOutlet(limits.waiting_bytes, connection.write, self._dropped.add)
        self._large_lock = asyncio.Lock()
        self._large_bytes = 0

    def pause(self) -> None:
        """Keep messages of topics waiting."""
        self.data.pause()

    def resume(self) -> None:
        """Send the waiting messages."""
        self._large_bytes = 0
        self.data.resume()

    def end(self) -> None:
        """Stop sending, because the connection has ended."""
        self._dropped.close()
        self.data.end()

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

    async def _wait_for_room(self) -> None:
        while not self.connection.has_room.is_set():
            before = self.connection.unsent_bytes
            has_room = await occurs_within(self.connection.has_room, _LARGE_STEP_S)
            if not has_room and self.connection.unsent_bytes > before - _LARGE_STEP_BYTES:
                self.abort()
                return
