"""Services of the in-memory graph."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from rostether.errors import (
    RostetherError,
    ServiceCallError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TypeMismatchError,
)
from rostether.graph.callbacks import report_error
from rostether.graph.ports import ServiceHandler
from rostether.mechanisms.tasks import start_task
from rostether.msgdef.interface import ANY_MD5SUM, ServiceType


class MemoryServiceServer:
    """Implements `ServiceServer`; calls run concurrently, and continue after their caller has given up."""

    def __init__(
        self,
        service: str,
        service_type: ServiceType,
        node_name: str,
        handler: ServiceHandler,
        on_close: Callable[[MemoryServiceServer], None],
    ) -> None:
        self.service = service
        self.type = service_type
        self.node_name = node_name
        self._handler = handler
        self._on_close = on_close
        self._calls: set[asyncio.Task[bytes]] = set()
        self._is_closed = False

    async def call(self, service_type: ServiceType, request: bytes, timeout_s: float | None) -> bytes:
        """Run the handler. Raises the errors of `Graph.call_service`."""
        if service_type.md5sum not in (self.type.md5sum, ANY_MD5SUM):
            raise TypeMismatchError(
                f"service {self.service} has type {self.type.name} (md5sum {self.type.md5sum}), "
                f"not {service_type.name} (md5sum {service_type.md5sum}); make both ends use one definition"
            )
        task = start_task(self._calls, self._answer(request))
        # If the caller has given up, an error of the handler is ignored.
        task.add_done_callback(lambda ended: ended.cancelled() or ended.exception())
        done, _ = await asyncio.wait((task,), timeout=timeout_s)
        if not done:
            raise ServiceTimeoutError(
                f"service {self.service} did not answer within {timeout_s:g} s; check that its node does not"
                " hang"
            )
        if task.cancelled():
            raise ServiceUnavailableError(f"service {self.service} was shut down during the call")
        return task.result()

    async def close(self) -> None:
        """Unadvertise; pending calls fail. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            for task in self._calls:
                task.cancel()
            self._on_close(self)

    async def _answer(self, request: bytes) -> bytes:
        try:
            return await self._handler(request)
        except RostetherError as error:
            raise ServiceCallError(str(error)) from error
        except Exception as error:
            report_error(f"handler of service {self.service}", error)
            raise ServiceCallError(f"error processing request: {error}") from error
