"""Relays one service: offers it in one graph, and calls it in the other one."""

from __future__ import annotations

import asyncio

from rostether.graph.ports import ServiceServer
from rostether.msgdef.interface import ANY_TYPE
from rostether.relay.side import RelaySide


class ServiceRelay:
    """Forwards calls from `open` to `close`; `chosen_type` is the type that the user gave, or empty."""

    def __init__(self, service: str, source: RelaySide, target: RelaySide, chosen_type: str) -> None:
        # `*` before the type is known.
        self.type_name = ANY_TYPE
        self._service = service
        self._source = source
        self._target = target
        self._chosen_type = chosen_type
        self._server: ServiceServer | None = None

    async def open(self) -> None:
        """Offer the service. Raises RostetherError."""
        service_type = await self._source.find_service_type(self._service, self._chosen_type)
        self.type_name = service_type.name

        async def call(request: bytes) -> bytes:
            return await self._source.graph.call_service(self._service, service_type, request)

        self._server = await self._target.graph.advertise_service(self._service, service_type, call)

    async def wait_for_new_type(self) -> None:
        """Wait until canceled: a service keeps its type."""
        await asyncio.Event().wait()

    async def close(self) -> None:
        """Withdraw the service. Raises GraphError."""
        if self._server is not None:
            await self._server.close()
