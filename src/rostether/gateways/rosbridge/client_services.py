"""The services of one client: those that it calls, and those that it offers."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from rostether.errors import InvalidNameError, RemoteProtocolError, RostetherError, UnknownNameError
from rostether.gateways.rosbridge.client_subscription import Delivery
from rostether.gateways.rosbridge.offered_services import OfferedService
from rostether.gateways.rosbridge.request import Request, fields_by_name
from rostether.gateways.rosbridge.rosbridge_context import RosbridgeContext
from rostether.gateways.rosbridge.settings import MAX_CALLS, MAX_QUEUED_BYTES, MAX_SERVICES, check_allowed
from rostether.gateways.rosbridge.values import JsonText
from rostether.gateways.type_names import short_type

# Responses that the gateway computes for one client at once: a page with many requests must not delay others.
_MAX_LOCAL_CALLS = 2

Send = Callable[[dict[str, Any], Delivery], None]


class ClientServices:
    """The services that one client calls or offers. Methods raise RostetherError."""

    def __init__(self, context: RosbridgeContext, send: Send) -> None:
        self._context = context
        self._send = send
        self._calls: dict[asyncio.Task[None], int] = {}
        self._call_bytes = 0
        self._local_calls = asyncio.Semaphore(_MAX_LOCAL_CALLS)

    def call(self, request: Request) -> None:
        """Call a service; the answer is sent when it arrives, independently of other requests."""
        service, delivery = request.word("service"), Delivery.read(request)
        timeout_s = request.number("timeout", 0) or None
        is_too_large = self._calls and self._call_bytes + request.size_bytes > MAX_QUEUED_BYTES
        if len(self._calls) >= MAX_CALLS or is_too_large:
            # Refused rather than delayed: the client's next message may stop a robot.
            amount = f"{self._call_bytes} bytes of" if is_too_large else MAX_CALLS
            reason = f"this client has {amount} pending calls; wait for a response before you call {service}"
            self._send(_response(request, service) | {"values": reason, "result": False}, delivery)
            return
        task = asyncio.ensure_future(self._call(request, service, delivery, timeout_s))
        self._calls[task] = request.size_bytes
        self._call_bytes += request.size_bytes
        task.add_done_callback(self._call_ended)

    async def advertise(self, request: Request) -> str:
        """Offer a service that the client answers; return a warning, empty if there is none."""
        name = self._context.graph.resolve(request.word("service"))
        check_allowed(name, self._context.settings.services_glob, "services_glob")
        if len(self._context.offered.of(self)) >= MAX_SERVICES:
            raise RemoteProtocolError(
                f"advertise_service: at most {MAX_SERVICES} services are allowed; unadvertise some"
            )
        service_type = self._context.store.registry.service_type(short_type(request.word("type")))
        send = self._send
        service = OfferedService(
            name, service_type, self, self._context.forms, lambda fields: send(fields, Delivery())
        )
        old = await self._context.offered.offer(service)
        if old is not None and old.owner is not self:
            return f"advertise_service: {name} was offered by another client; this client replaces it"
        return ""

    async def unadvertise(self, request: Request) -> None:
        """Stop offering a service."""
        service = self._own(request)
        await self._context.offered.withdraw(service, "was unadvertised while it was called")

    async def answer(self, request: Request) -> None:
        """Handle the client's answer to a call."""
        await self._own(request).answer(request)

    async def close(self) -> None:
        """Cancel calls, and stop offering services."""
        for call in self._calls:
            call.cancel()
        withdrawals = (
            self._context.offered.withdraw(each, "ended: the client that offers it has disconnected")
            for each in self._context.offered.of(self)
        )
        await asyncio.gather(*withdrawals, *self._calls, return_exceptions=True)

    def _call_ended(self, task: asyncio.Task[None]) -> None:
        self._call_bytes -= self._calls.pop(task)

    async def _call(
        self, request: Request, service: str, delivery: Delivery, timeout_s: float | None
    ) -> None:
        answer = _response(request, service)
        try:
            async with asyncio.timeout(timeout_s):
                values: Any = await self._values(service, request)
            answer |= {"values": values, "result": True}
        except RostetherError as error:
            answer |= {"values": str(error), "result": False}
        except TimeoutError:
            problem = f"service {service} did not answer within {timeout_s:g} s"
            answer |= {"values": f"{problem}; check that its node does not hang", "result": False}
        self._send(answer, delivery)

    async def _values(self, service: str, request: Request) -> dict[str, Any] | JsonText:
        context = self._context
        try:
            name = context.graph.resolve(service)
        except InvalidNameError as error:
            raise RemoteProtocolError(f"call_service: {error}") from None
        check_allowed(name, self._context.settings.services_glob, "services_glob")
        local = context.local_services.find(name) if context.local_services is not None else None
        if local is not None:
            async with self._local_calls:
                return await local(request.fields.get("args"))
        service_type = await context.service_types.find(name)
        codec = context.store.codec(service_type.request.name)
        args = fields_by_name(codec, request.fields.get("args"))
        payload = await context.forms.payload(service_type.request.name, args, request)
        # Free the parsed request, which needs twenty times the memory of its JSON: calls may take minutes.
        del args
        request.fields.clear()
        try:
            answer = await context.graph.call_service(name, service_type, payload)
        except RostetherError:
            context.service_types.forget(name)
            raise
        return await context.forms.response(service_type.response.name, answer)

    def _own(self, request: Request) -> OfferedService:
        name = self._context.graph.resolve(request.word("service"))
        service = self._context.offered.find(name, self)
        if service is None:
            raise UnknownNameError(f"{request.op}: this client does not offer {name}; advertise it first")
        return service


def _response(request: Request, service: str) -> dict[str, Any]:
    answer: dict[str, Any] = {"op": "service_response", "service": service}
    if request.id is not None:
        answer["id"] = request.id
    return answer
