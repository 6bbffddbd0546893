"""A node of a ROS 2 graph over zenoh: the graph port by rmw_zenoh's conventions."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Container, Mapping
from contextlib import AsyncExitStack

from rostether.errors import GraphError
from rostether.graph.ports import Level, OnMessages, ParamValue, ServiceHandler, Snapshot
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.names.resolve import resolve_name, resolve_remappings
from rostether.ros2.clock import NodeClock
from rostether.ros2.endpoint_info import EndpointInfo
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.naming import validate_topic_name
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.parameter_methods import ParameterMethods
from rostether.ros2.parameters.services import ParameterServices
from rostether.ros2.parameters.store import ParameterStore
from rostether.ros2.rosout import RosoutLog
from rostether.ros2.zenoh.endpoint_handles import Endpoints
from rostether.ros2.zenoh.endpoint_list import list_endpoints
from rostether.ros2.zenoh.entities import NodeEntities
from rostether.ros2.zenoh.publication import Publisher
from rostether.ros2.zenoh.service_server import ServiceServer
from rostether.ros2.zenoh.session import ZenohSession
from rostether.ros2.zenoh.subscription import Subscription
from rostether.rostime import Time

_log = logging.getLogger("rostether.ros2")

_LOGGING_LEVELS = {
    Level.DEBUG: logging.DEBUG,
    Level.INFO: logging.INFO,
    Level.WARN: logging.WARNING,
    Level.ERROR: logging.ERROR,
    Level.FATAL: logging.CRITICAL,
}


class ZenohGraph(ParameterMethods):
    """A `graph.ports.Graph`; made by `ZenohSession.join`."""

    def __init__(
        self,
        session: ZenohSession,
        node_name: str,
        namespace: str,
        remappings: Mapping[str, str],
        parameters: Mapping[str, ParamValue],
    ) -> None:
        self.node_name = node_name
        self._session = session
        self._namespace = namespace
        self._remappings = resolve_remappings(remappings, namespace=namespace, node_name=node_name)
        self._endpoints = Endpoints(NodeEntities(session, node_name), report=self._report)
        store = ParameterStore(parameters)
        self._parameters = GraphParameters(store, self)
        self._parameter_services = ParameterServices(store, self)
        self._clock = NodeClock(store, self)
        self._rosout = RosoutLog(node_name, self._clock.now)
        self._closing: asyncio.Task[None] | None = None
        self._closed = asyncio.Event()
        self._reason = ""

    def resolve(self, name: str) -> str:
        """Return the fully qualified, remapped form of a name. Raises InvalidNameError."""
        return resolve_name(
            name, namespace=self._namespace, node_name=self.node_name, remappings=self._remappings
        )

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> Publisher:
        """Advertise a topic. `queue_bytes` bounds what waits while a link is full; zenoh itself queues 1 MiB.

        Raises TypeMismatchError, UnknownTypeError, InvalidNameError.
        """
        self._check_open()
        return self._endpoints.advertise(
            self._resolve_ros2(topic), message_type, latch=latch, queue_bytes=queue_bytes
        )

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
    ) -> Subscription:
        """Subscribe. `ANY_MESSAGE` accepts every type; `on_connection` is called for each publisher."""
        self._check_open()
        return self._endpoints.subscribe(
            self._resolve_ros2(topic),
            message_type,
            on_messages,
            on_connection=on_connection,
            skip_own=skip_own,
            skip_nodes=skip_nodes,
        )

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ServiceServer:
        """Offer a service. A handler that raises RostetherError fails the call with that error's text."""
        self._check_open()
        return self._endpoints.advertise_service(self._resolve_ros2(service), service_type, handler)

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError.
        """
        self._check_open()
        return await self._endpoints.call_service(
            self._resolve_ros2(service), service_type, request, timeout_s=timeout_s
        )

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """Be listed as a client of a service. Raises UnknownTypeError, TypeMismatchError."""
        self._check_open()
        return self._endpoints.list_client(self._resolve_ros2(service), service_type)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self._endpoints.publish_log(self._rosout.encode(level, text))

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return self._clock.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        return self._session.graph.snapshot()

    async def endpoints(self) -> list[EndpointInfo]:
        """Return every end of every topic and service that is known now."""
        return list_endpoints(self._session.graph.all_endpoints())

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change."""
        return self._session.graph.changes(self._closed)

    async def close(self, reason: str = "closed") -> None:
        """Leave the graph: everything advertised, subscribed or watched ends. Idempotent."""
        if self._closing is None:
            self._reason = reason
            self._closing = asyncio.ensure_future(self._close())
        await asyncio.shield(self._closing)

    async def wait_closed(self) -> str:
        """Wait until the node has left, by `close` or with its session; returns the reason."""
        await self._closed.wait()
        return self._reason

    async def open(self) -> None:
        """Appear in the graph; `ZenohSession.join` does it."""
        self._endpoints.open()
        await self._clock.open()
        await self._parameter_services.open()

    async def _close(self) -> None:
        try:
            async with AsyncExitStack() as stack:
                # Backwards: what uses the endpoints ends before they do.
                stack.push_async_callback(self._endpoints.close)
                stack.push_async_callback(self._parameter_services.close)
                stack.push_async_callback(self._clock.close)
                stack.push_async_callback(self._parameters.close)
        finally:
            self._session.leave(self)
            self._closed.set()

    def _resolve_ros2(self, name: str) -> str:
        return validate_topic_name(self.resolve(name))

    def _report(self, level: Level, text: str) -> None:
        _log.log(_LOGGING_LEVELS[level], "%s: %s", self.node_name, text)
        self.log(level, text)

    def _check_open(self) -> None:
        if self._closing is not None:
            raise GraphError(f"node {self.node_name} has left the graph; join again")
