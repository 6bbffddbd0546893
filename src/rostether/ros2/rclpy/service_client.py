"""A node's client of one service, shared by all callers."""

from __future__ import annotations

import asyncio
from typing import Any

from rostether.errors import ServiceCallError, ServiceUnavailableError, TypeMismatchError
from rostether.graph.service_calls import answer_within
from rostether.ros2.early_conversion import convert
from rostether.ros2.rclpy.executor_thread import set_result
from rostether.ros2.rclpy.failures import attempt
from rostether.ros2.rclpy.installation import interface_class, load_rclpy
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.quality import SERVICE_DEPTH, profile
from rostether.ros2.types.type_support import ServiceSupport

# The time limit for finding a service: DDS announces it immediately, and again after 3 s if that is lost.
DISCOVERY_S = 3.5

# The polling interval for a server that is being discovered.
SERVICE_POLL_INTERVAL_S = 0.01

# The interval between checks that the server of a pending call is alive; middlewares do not report it.
SERVER_CHECK_INTERVAL_S = 0.25


class RclpyServiceClient:
    """One client of rclpy, kept for later calls: finding the server again would delay each of them."""

    def __init__(self, own: OwnNode, service: str, support: ServiceSupport) -> None:
        self.service = service
        self._own = own
        self._support = support
        self._client: Any = None

    def open(self) -> None:
        """Create the client, in the executor's thread.

        Raises GraphError and its subclasses, UnknownTypeError.
        """
        type_class = interface_class(self._support.name)
        self._client = self._own.create(
            f"call {self.service}",
            self._support.name,
            lambda: self._own.node.create_client(
                type_class, self.service, qos_profile=profile(SERVICE_DEPTH), callback_group=self._own.group
            ),
            lambda: self._own.service_types(self.service),
        )

    def end(self) -> None:
        """Destroy rclpy's client, in the executor's thread."""
        client, self._client = self._client, None
        if client is not None:
            self._own.node.destroy_client(client)

    async def call(self, request: bytes, timeout_s: float | None) -> bytes:
        """Call the service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        SerializationError.
        """
        cdr = self._support.request.to_cdr(request)
        await self._find_server(DISCOVERY_S if timeout_s is None else min(timeout_s, DISCOVERY_S))
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        pending = await self._own.thread.run(lambda: self._send(cdr, answer))
        try:
            async with answer_within(self.service, timeout_s):
                response = await self._wait(answer)
        finally:
            if not answer.done() or answer.cancelled():
                self._own.thread.submit(lambda: self._forget(pending))
        return await convert(self._support.response.from_cdr, response)

    async def _find_server(self, limit_s: float) -> None:
        loop = asyncio.get_running_loop()
        deadline_s = loop.time() + limit_s
        while not self._is_ready():
            absence = await self._own.thread.run(self._explain_absence)
            # A service of another type is reported immediately.
            if isinstance(absence, TypeMismatchError) or loop.time() >= deadline_s:
                raise absence
            await asyncio.sleep(SERVICE_POLL_INTERVAL_S)

    def _is_ready(self) -> bool:
        if self._client is None:
            raise ServiceCallError(f"the node stopped before {self.service} was called")
        return attempt(f"call {self.service}", lambda: bool(self._client.service_is_ready()))

    def _explain_absence(self) -> TypeMismatchError | ServiceUnavailableError:
        types = self._own.service_types(self.service)
        if types and self._support.name not in types:
            return TypeMismatchError(
                f"{self.service} is {' and '.join(types)}, not {self._support.name}; call it with its type"
            )
        return ServiceUnavailableError(f"no node offers the service {self.service}; start its node")

    def _send(self, cdr: bytes, answer: asyncio.Future[bytes]) -> Any:
        serialization = load_rclpy().serialization
        if self._client is None:
            raise ServiceCallError(f"the node stopped before {self.service} was called")
        request = serialization.deserialize_message(cdr, self._client.srv_type.Request)

        def done(future: Any) -> None:
            if not future.cancelled() and future.exception() is None:
                response = serialization.serialize_message(future.result())
                self._own.thread.call_in_loop(set_result, answer, response)

        pending = self._client.call_async(request)
        pending.add_done_callback(done)
        return pending

    async def _wait(self, answer: asyncio.Future[bytes]) -> bytes:
        while not answer.done():
            await asyncio.wait((answer,), timeout=SERVER_CHECK_INTERVAL_S)
            if not answer.done() and not self._is_ready():
                raise ServiceCallError(f"service {self.service} was shut down during the call")
        return answer.result()

    def _forget(self, pending: Any) -> None:
        if self._client is not None:
            self._client.remove_pending_request(pending)
