"""Relays one service: offers it in one graph, and calls it in the other one."""

from __future__ import annotations

import asyncio

from rostether.graph.ports import ServiceServer
from rostether.msgdef.interface import ANY_TYPE, ServiceType
from rostether.relay.side import Side


class ServiceRelay:
    """Forwards calls until it is closed."""

    def __init__(self, service: str, source: Side, target: Side, chosen_type: str) -> None:
        self.service = service
        self.source = source
        self.target = target
        self.type: ServiceType | None = None
        self._chosen_type = chosen_type
        self._server: ServiceServer | None = None
        self._is_closed = False

    @property
    def type_name(self) -> str:
        """The name of the type, `*` before it is known."""
        return ANY_TYPE if self.type is None else self.type.name

    async def open(self) -> None:
        """Offer the service. Raises RostetherError."""
        self.type = service_type = await self.source.find_service_type(self.service, self._chosen_type)

        async def call(request: bytes) -> bytes:
            return await self.source.graph.call_service(self.service, service_type, request)

        server = await self.target.graph.advertise_service(self.service, service_type, call)
        if self._is_closed:
            await server.close()
            return
        self._server = server

    async def wait_for_new_type(self) -> None:
        """Wait until cancelled: a service keeps its type."""
        await asyncio.Event().wait()

    async def close(self) -> None:
        """Withdraw the service. Idempotent. Raises GraphError."""
        self._is_closed = True
        server, self._server = self._server, None
        if server is not None:
            await server.close()
