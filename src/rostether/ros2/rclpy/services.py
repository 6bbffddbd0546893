"""Services over rclpy: a node's clients, shared by all callers, and the services that it offers."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from rostether.errors import (
    RostetherError,
    ServiceCallError,
    ServiceUnavailableError,
    TypeMismatchError,
)
from rostether.graph.callbacks import report_error
from rostether.graph.ports import Level, ServiceHandler
from rostether.graph.service_calls import answer_within
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.ros2.early_conversion import convert
from rostether.ros2.rclpy.executor_thread import NoAnswerError, set_result
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


class RclpyServiceServer:
    """Implements `graph.ports.ServiceServer`.

    ROS 2 cannot report that a call failed. If the handler fails, there is no answer: the caller's time limit
    ends the call, and /rosout has the reason.
    """

    def __init__(
        self,
        own: OwnNode,
        service: str,
        support: ServiceSupport,
        handler: ServiceHandler,
        on_close: Callable[[RclpyServiceServer], Awaitable[None]],
    ) -> None:
        self.service = service
        self._own = own
        self._support = support
        self._handler = handler
        self._on_close = on_close
        self._entity: Any = None
        self._calls: set[asyncio.Task[None]] = set()
        self._is_closed = False

    def open(self) -> None:
        """Advertise, in the executor's thread. Raises GraphError, InvalidNameError, UnknownTypeError."""
        rclpy = load_rclpy()
        type_class = interface_class(self._support.name)
        serialize = rclpy.serialization.serialize_message
        deserialize = rclpy.serialization.deserialize_message

        async def callback(request: Any, _response: Any) -> Any:
            answer = rclpy.task.Future(executor=self._own.thread.executor)
            self._own.thread.call_in_loop(self._start, serialize(request), answer)
            cdr = await answer
            if cdr is None:
                raise NoAnswerError
            return deserialize(cdr, type_class.Response)

        self._entity = self._own.create(
            f"offer the service {self.service}",
            self._support.name,
            lambda: self._own.node.create_service(
                type_class,
                self.service,
                callback,
                qos_profile=profile(SERVICE_DEPTH),
                callback_group=self._own.group,
            ),
            lambda: self._own.service_types(self.service),
        )

    async def close(self) -> None:
        """Unadvertise. Idempotent; calls that are being served end without an answer."""
        if self._is_closed:
            return
        self._is_closed = True
        await cancel_all(*self._calls)
        await self._on_close(self)

    def end(self) -> None:
        """Destroy rclpy's service, in the executor's thread."""
        entity, self._entity = self._entity, None
        if entity is not None:
            self._own.node.destroy_service(entity)

    def _start(self, request: bytes, answer: Any) -> None:
        if self._is_closed:
            self._finish(answer, None)
            return
        start_task(self._calls, self._serve(request, answer))

    async def _serve(self, request: bytes, answer: Any) -> None:
        cdr: bytes | None = None
        try:
            response = await self._handler(await convert(self._support.request.from_cdr, request))
            cdr = self._support.response.to_cdr(response)
        except RostetherError as error:
            self._own.report(Level.WARN, f"no answer to a call of {self.service}: {error}")
        except Exception as error:  # noqa: BLE001 - an error in a handler must not end the node
            report_error(f"handler of service {self.service}", error)
            self._own.log(Level.ERROR, f"no answer to a call of {self.service}: {error}")
        finally:
            self._finish(answer, cdr)

    def _finish(self, answer: Any, cdr: bytes | None) -> None:
        answer.set_result(cdr)
        # The executor checks for new requests only when it wakes up.
        self._own.thread.executor.wake()
