"""A node of a ROS 2 graph: the graph port over rclpy."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Container, Mapping

from rostether.errors import GraphError
from rostether.graph.ports import Level, OnMessages, ServiceHandler, Snapshot
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.names.resolve import resolve_name, resolve_remappings
from rostether.ros2.endpoint_info import EndpointInfo
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.parameter_methods import ParameterMethods
from rostether.ros2.rclpy.endpoint_handles import Endpoints
from rostether.ros2.rclpy.endpoint_list import list_endpoints
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.own_parameters import RclpyParameters
from rostether.ros2.rclpy.publication import RclpyPublisher
from rostether.ros2.rclpy.service_server import RclpyServiceServer
from rostether.ros2.rclpy.subscription import RclpySubscriber
from rostether.ros2.rclpy.view import take_snapshot, watch_changes
from rostether.rostime import Time


class RclpyGraph(ParameterMethods):
    """A `graph.ports.Graph`; made by `RclpyContext.join`."""

    def __init__(
        self,
        own: OwnNode,
        namespace: str,
        remappings: Mapping[str, str],
        *,
        on_close: Callable[[RclpyGraph], object],
    ) -> None:
        self.node_name = own.name
        self._own = own
        self._namespace = namespace
        self._remappings = resolve_remappings(remappings, namespace=namespace, node_name=own.name)
        self._on_close = on_close
        self._endpoints = Endpoints(own)
        self._parameters = GraphParameters(RclpyParameters(own), self)
        self._closing: asyncio.Task[None] | None = None
        self._closed = asyncio.Event()

    def resolve(self, name: str) -> str:
        """Return the fully qualified, remapped form of a name. Raises InvalidNameError."""
        return resolve_name(
            name, namespace=self._namespace, node_name=self.node_name, remappings=self._remappings
        )

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> RclpyPublisher:
        """Advertise a topic; queues are the middleware's, counted in messages.

        Raises UnknownTypeError for a type whose package is not installed, TypeMismatchError where this
        process uses the topic with another type.
        """
        self._check_open()
        return await self._endpoints.advertise(self.resolve(topic), message_type, latch=latch)

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        *,
        on_connection: Callable[[Mapping[str, str]], None] | None = None,
        tcp_nodelay: bool = True,
        skip_own: bool = False,
        skip_nodes: Container[str] = (),
    ) -> RclpySubscriber:
        """Subscribe. `ANY_MESSAGE` takes the type that the first publisher has, once there is one.

        Raises UnknownTypeError, TypeMismatchError as `advertise`.
        """
        self._check_open()
        return await self._endpoints.subscribe(
            self.resolve(topic),
            message_type,
            on_messages,
            on_connection=on_connection,
            skip_own=skip_own,
            skip_nodes=skip_nodes,
        )

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> RclpyServiceServer:
        """Offer a service. A call whose handler fails gets no answer; /rosout has the reason."""
        self._check_open()
        return await self._endpoints.advertise_service(self.resolve(service), service_type, handler)

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError.
        """
        self._check_open()
        return await self._endpoints.call_service(self.resolve(service), service_type, request, timeout_s)

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """Be listed as a client of a service. Raises UnknownTypeError, TypeMismatchError."""
        self._check_open()
        return await self._endpoints.list_client(self.resolve(service), service_type)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self._own.log(level, text)

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return Time.from_ns(self._own.now_ns())

    async def snapshot(self) -> Snapshot:
        """Return the whole graph as this node knows it."""
        return await self._own.thread.run(lambda: take_snapshot(self._own.node))

    async def endpoints(self) -> list[EndpointInfo]:
        """Return every end of every topic and service that is known now."""
        return await self._own.thread.run(lambda: list_endpoints(self._own.node))

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change, within about half a second of it."""
        return watch_changes(self.snapshot, self._closed)

    async def close(self) -> None:
        """Leave the graph: everything advertised, subscribed or watched ends. Idempotent."""
        if self._closing is None:
            self._closing = asyncio.ensure_future(self._close())
        await asyncio.shield(self._closing)

    async def wait_closed(self) -> str:
        """Wait until the node has left by `close`; ROS 2 has no shutdown request for nodes."""
        await self._closed.wait()
        return "closed"

    async def _close(self) -> None:
        try:
            await self._parameters.close()
            await self._endpoints.close()
            await self._own.thread.run(self._own.destroy)
        finally:
            await self._own.thread.stop()
            self._on_close(self)
            self._closed.set()

    def _check_open(self) -> None:
        if self._closing is not None:
            raise GraphError(f"node {self.node_name} has left the graph; join again")
