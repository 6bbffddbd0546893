"""A connection of rosbridge's server that went through the gateway's door, or is hung up on."""

from __future__ import annotations

import asyncio
from typing import Any

from websockets.asyncio.server import ServerConnection

from rostether.gateways.connection_limiter import ConnectionLimiter


class DoorConnection(ServerConnection):
    """A connection that is counted from its first moment to its last."""

    def __init__(self, door: ConnectionLimiter, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._door = door
        self._is_counted = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take the connection, or end it before anything is read."""
        super().connection_made(transport)
        self._is_counted = self._door.admit(transport)
        if not self._is_counted:
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Free the place."""
        if self._is_counted:
            self._is_counted = False
            self._door.release()
        super().connection_lost(exc)
