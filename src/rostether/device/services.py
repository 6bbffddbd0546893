"""The service handles of a device.

The protocol has no correlation id: one call at a time is in flight for each service, and a response belongs
to that call.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Any, Generic, TypeAlias, cast

from rostether.device.endpoint_handles import Declared, Fields
from rostether.device.line import DeviceLine
from rostether.errors import (
    RostetherError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TransportClosedError,
)
from rostether.rosserial.device_endpoints import ServiceIds
from rostether.serde.codec import Codec
from rostether.serde.type_classes import Request, Response
from rostether.serde.values import Message

Answer: TypeAlias = Response | Mapping[str, Any] | None
Handler: TypeAlias = Callable[[Request], Answer[Response] | Awaitable[Answer[Response]]]

# A host waits for each response before it calls again, so more than a few pending requests are a fault.
MAX_WAITING_REQUESTS = 16

_LOG = logging.getLogger(__name__)


class ServiceServer(Declared):
    """Answers calls from the host, one after the other; `Device.service_server` returns it."""

    def __init__(
        self,
        service: str,
        ids: ServiceIds,
        codecs: tuple[Codec, Codec],
        handler: Handler[Any, Any],
        line: DeviceLine,
        on_failure: Callable[[str], None],
    ) -> None:
        self.service = service
        self._ids = ids
        self._request_codec, self._response_codec = codecs
        self._handler = handler
        self._line = line
        self._on_failure = on_failure
        self._waiting: deque[bytes] = deque(maxlen=MAX_WAITING_REQUESTS)
        self._task: asyncio.Task[None] | None = None

    def receive(self, payloads: Iterable[bytes]) -> None:
        """Queue requests, which are answered in order."""
        self._waiting.extend(payloads)
        if self._task is None and self._waiting:
            self._task = asyncio.get_running_loop().create_task(self._answer_all())

    def close(self) -> None:
        """Cancel requests that are being handled."""
        self._waiting.clear()
        if self._task is not None:
            self._task.cancel()

    async def _answer_all(self) -> None:
        try:
            while self._waiting:
                await self._answer(self._waiting.popleft())
        finally:
            self._task = None

    async def _answer(self, payload: bytes) -> None:
        try:
            answer = self._handler(self._request_codec.decode(payload))
            if answer is not None and not isinstance(answer, Message | Mapping):
                answer = await cast("Awaitable[Fields | None]", answer)
            response = self._response_codec.encode(answer if answer is not None else {})
            self._line.publish(self._ids.response_id, [response])
        except RostetherError as error:
            self._on_failure(f"service {self.service} failed: {error}")
        except Exception as error:  # noqa: BLE001 - the program's own code may raise anything
            # The protocol cannot report a failure to the caller: its call times out. The host receives a log
            # message.
            _LOG.exception("the handler of service %s failed", self.service)
            self._on_failure(f"service {self.service} failed: {type(error).__name__}: {error}")


class ServiceClient(Declared, Generic[Response]):
    """Calls a service of ROS through the host; `Device.service_client` returns it."""

    def __init__(
        self,
        service: str,
        ids: ServiceIds,
        codecs: tuple[Codec, Codec],
        line: DeviceLine,
        wait_connected: Callable[[], Awaitable[None]],
        no_host_cause: Callable[[], str],
    ) -> None:
        self.service = service
        self._ids = ids
        self._request_codec, self._response_codec = codecs
        self._line = line
        self._wait_connected = wait_connected
        self._no_host_cause = no_host_cause
        self._in_flight: asyncio.Future[bytes] | None = None
        self._lock = asyncio.Lock()

    async def call(
        self, request: Fields | None = None, /, *, timeout_s: float = 5.0, **fields: Any
    ) -> Response:
        """Call the service and return its response.

        The call waits for the host to connect, and for earlier calls. Raises ServiceTimeoutError,
        ServiceUnavailableError, SerializationError.
        """
        payload = self._request_codec.encode_given(request, fields)
        try:
            async with asyncio.timeout(timeout_s), self._lock:
                await self._wait_connected()
                response = await self._exchange(payload)
        except TransportClosedError as error:
            raise ServiceUnavailableError(f"service {self.service}: {error}") from None
        except TimeoutError:
            cause = self._no_host_cause() or "; check that its node runs"
            raise ServiceTimeoutError(
                f"service {self.service} did not answer within {timeout_s:g} s{cause}"
            ) from None
        return cast("Response", self._response_codec.decode(response))

    def receive(self, payloads: Iterable[bytes]) -> None:
        """Handle a response; a response after the time limit is dropped."""
        for payload in payloads:
            if self._in_flight is not None and not self._in_flight.done():
                self._in_flight.set_result(payload)

    def fail(self, reason: str) -> None:
        """End the call in flight, because the line was lost or closed."""
        if self._in_flight is not None and not self._in_flight.done():
            self._in_flight.set_exception(ServiceUnavailableError(f"service {self.service}: {reason}"))

    async def _exchange(self, payload: bytes) -> bytes:
        self._in_flight = asyncio.get_running_loop().create_future()
        try:
            if not self._line.publish(self._ids.request_id, [payload]):
                raise ServiceUnavailableError(
                    f"service {self.service}: the line to the host is full; try again"
                )
            return await self._in_flight
        finally:
            self._in_flight = None
