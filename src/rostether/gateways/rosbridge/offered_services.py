"""Services that clients offer to the graph: calls are forwarded to the client over its connection."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from itertools import count
from typing import Any

from rostether.errors import ServiceCallError, UnknownNameError
from rostether.gateways.client_json import show
from rostether.gateways.rosbridge.message_forms import MessageForms
from rostether.gateways.rosbridge.request import Request
from rostether.gateways.rosbridge.settings import MAX_CALLS
from rostether.graph.ports import Graph, ServiceServer
from rostether.mechanisms.text import fold_line
from rostether.msgdef.interface import ServiceType

# Iterations of the event loop until an answer is sent to its caller.
_TURNS_TO_ANSWER = 4


class OfferedService:
    """One service that a client answers; `send` queues a message for the client."""

    def __init__(
        self,
        name: str,
        service_type: ServiceType,
        owner: object,
        forms: MessageForms,
        send: Callable[[dict[str, Any]], None],
    ) -> None:
        self.name = name
        self.type = service_type
        self.owner = owner
        self.server: ServiceServer | None = None
        self._forms = forms
        self._send = send
        self._numbers = count(1)
        self._waiting: dict[str, asyncio.Future[bytes]] = {}

    async def handle(self, request: bytes) -> bytes:
        """Pass a call to the client and wait for its answer. Raises ServiceCallError."""
        if len(self._waiting) >= MAX_CALLS:
            raise ServiceCallError(
                f"the client that offers {self.name} has {MAX_CALLS} pending calls; call again later"
            )
        call_id = f"service_request:{self.name}:{next(self._numbers)}"
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._waiting[call_id] = answer
        try:
            args = self._forms.to_json(self.type.request.name, request)
            self._send({"op": "call_service", "id": call_id, "service": self.name, "args": args})
            return await answer
        finally:
            del self._waiting[call_id]

    async def answer(self, request: Request) -> None:
        """Handle the client's answer. Raises UnknownNameError, SerializationError."""
        call_id, values = request.id, request.fields.get("values", {})
        waiting = self._waiting.get(call_id) if isinstance(call_id, str) else None
        if waiting is None or waiting.done():
            raise UnknownNameError(f"service_response: no call of {self.name} has the id {show(call_id)}")
        if not request.fields.get("result", True):
            text = values if isinstance(values, str) and values else "the service reports a failure"
            waiting.set_exception(ServiceCallError(fold_line(text)))
            return
        try:
            payload = await self._forms.payload(self.type.response.name, values, request)
        except Exception as error:
            if not waiting.done():
                reason = f"the client that offers {self.name} sent an invalid answer: {error}"
                waiting.set_exception(ServiceCallError(reason))
            raise
        if not waiting.done():
            waiting.set_result(payload)

    async def close(self, reason: str) -> None:
        """Stop offering the service; waiting calls fail."""
        failing = [waiting for waiting in self._waiting.values() if not waiting.done()]
        for waiting in failing:
            waiting.set_exception(ServiceCallError(f"service {self.name} {reason}"))
        # Callers must get the reason before the end of the service, which ends their calls.
        for _ in range(_TURNS_TO_ANSWER if failing else 0):
            await asyncio.sleep(0)
        if self.server is not None:
            await self.server.close()


class OfferedServices:
    """All services that clients offer. If several clients offer a name, the last one answers its calls."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._services: dict[str, OfferedService] = {}
        # Offers of the same name run one after the other.
        self._lock = asyncio.Lock()

    def of(self, owner: object) -> list[OfferedService]:
        """Return a client's services."""
        return [service for service in self._services.values() if service.owner is owner]

    def find(self, name: str, owner: object) -> OfferedService | None:
        """Return a client's service by name, None if it does not offer one."""
        service = self._services.get(name)
        return service if service is not None and service.owner is owner else None

    async def offer(self, service: OfferedService) -> OfferedService | None:
        """Offer a service; return the one that it replaces, None if it is new. Raises GraphError."""
        async with self._lock:
            old = self._services.pop(service.name, None)
            if old is not None:
                await old.close("is now offered by another client")
            service.server = await self._graph.advertise_service(service.name, service.type, service.handle)
            self._services[service.name] = service
        return old

    async def withdraw(self, service: OfferedService, reason: str) -> None:
        """Stop offering a service."""
        if self._services.get(service.name) is service:
            del self._services[service.name]
        await service.close(reason)
