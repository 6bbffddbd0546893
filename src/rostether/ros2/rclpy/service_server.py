"""One service that a node offers through rclpy."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from rostether.errors import RostetherError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import Level, ServiceHandler
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.ros2.early_conversion import convert
from rostether.ros2.rclpy.executor_thread import NoAnswerError
from rostether.ros2.rclpy.installation import interface_class, load_rclpy
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.quality import SERVICE_DEPTH, profile
from rostether.ros2.types.type_support import ServiceSupport


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
