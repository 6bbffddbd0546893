"""The handle to a client that is listed in a ROS 2 graph before it calls."""

from __future__ import annotations

from collections.abc import Awaitable, Callable


class ListedClient:
    """Implements `graph.ports.ServiceClient`; `close` calls `withdraw` once."""

    def __init__(self, withdraw: Callable[[], Awaitable[None]]) -> None:
        self._withdraw = withdraw
        self._is_closed = False

    async def close(self) -> None:
        """Remove the client from the graph. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            await self._withdraw()
