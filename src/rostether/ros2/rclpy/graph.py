"""A node of a ROS 2 graph: the graph port over rclpy."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from typing import Any, Unpack

from rostether.graph.ports import Level, OnMessages, ServiceHandler, Snapshot, SubscribeOptions
from rostether.graph.publisher_handle import PublisherHandle
from rostether.graph.shared_snapshots import poll_snapshots
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.ros2_membership import Ros2Membership
from rostether.ros2.rclpy.endpoint_handles import RclpyEndpoints
from rostether.ros2.rclpy.installation import rclpy_distribution
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.own_parameters import RclpyParameters
from rostether.ros2.rclpy.publication import RclpyPublication
from rostether.ros2.rclpy.service_server import RclpyServiceServer
from rostether.ros2.rclpy.subscription import RclpySubscriber
from rostether.ros2.rclpy.view import POLL_INTERVAL_S, UNKNOWN_NODE, ask_node, full_name, take_snapshot
from rostether.rostime import Time


class RclpyGraph(Ros2Membership):
    """Implements `graph.ports.Graph`; made by `RclpyContext.join`."""

    def __init__(
        self,
        own: OwnNode,
        namespace: str,
        remappings: Mapping[str, str],
        *,
        on_close: Callable[[RclpyGraph], object],
    ) -> None:
        super().__init__(own.name, namespace, remappings)
        self._own = own
        self._on_close = on_close
        self._endpoints = RclpyEndpoints(own)
        self._parameters = GraphParameters(RclpyParameters(own), self)

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> PublisherHandle[RclpyPublication]:
        """Advertise a topic. `queue_bytes` has no effect: the middleware's queues are limited in messages.

        Raises UnknownTypeError for a type whose package is not installed, TypeMismatchError if this process
        uses the topic with another type, InvalidNameError.
        """
        self._check_open()
        return await self._endpoints.advertise(self.resolve(topic), message_type, latch=latch)

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> RclpySubscriber:
        """Subscribe.

        `ANY_MESSAGE` uses the type of the first publisher. Raises the same errors as
        `advertise`.
        """
        self._check_open()
        return await self._endpoints.subscribe(self.resolve(topic), message_type, on_messages, options)

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> RclpyServiceServer:
        """Offer a service. A call whose handler fails gets no answer; /rosout has the reason.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        self._check_open()
        return await self._endpoints.advertise_service(self.resolve(service), service_type, handler)

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        UnknownTypeError, InvalidNameError, SerializationError.
        """
        self._check_open()
        return await self._endpoints.call_service(self.resolve(service), service_type, request, timeout_s)

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """Appear in the graph as a client of a service.

        Raises UnknownTypeError, TypeMismatchError, InvalidNameError.
        """
        self._check_open()
        return await self._endpoints.list_client(self.resolve(service), service_type)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self._own.log(level, text)

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return Time.from_ns(self._own.now_ns())

    async def snapshot(self) -> Snapshot:
        """Return this node's view of the whole graph."""
        return await self._own.thread.run(lambda: take_snapshot(self._own.node))

    async def endpoints(self) -> list[EndpointInfo]:
        """Return all known endpoints of topics and services."""
        return await self._own.thread.run(lambda: list_endpoints(self._own.node))

    async def distribution(self) -> str:
        """Return the distribution of the installed rclpy; empty if its version is unknown."""
        return rclpy_distribution()

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change, within about half a second of it."""
        return poll_snapshots(self.snapshot, self._closed, POLL_INTERVAL_S)

    async def _end(self) -> None:
        try:
            await self._parameters.close()
            await self._endpoints.close()
            await self._own.thread.run(self._own.destroy)
        finally:
            await self._own.thread.stop()
            self._on_close(self)


def list_endpoints(node: Any) -> list[EndpointInfo]:
    """Return all endpoints of topics and services; call it in the executor's thread."""
    return [*_topic_ends(node), *_service_ends(node)]


def _topic_ends(node: Any) -> Iterator[EndpointInfo]:
    for topic, _ in node.get_topic_names_and_types():
        for kind, ask in (
            (EndpointKind.PUBLISHER, node.get_publishers_info_by_topic),
            (EndpointKind.SUBSCRIPTION, node.get_subscriptions_info_by_topic),
        ):
            for info in ask(topic):
                if info.node_name != UNKNOWN_NODE:
                    yield EndpointInfo(
                        full_name(info.node_name, info.node_namespace),
                        kind,
                        topic,
                        info.topic_type,
                        str(getattr(info, "topic_type_hash", "")),
                        bytes(info.endpoint_gid),
                        _report(info.qos_profile),
                    )


def _service_ends(node: Any) -> Iterator[EndpointInfo]:
    for name, namespace in node.get_node_names_and_namespaces():
        if name == UNKNOWN_NODE:
            continue
        for kind, ask in (
            (EndpointKind.SERVER, node.get_service_names_and_types_by_node),
            (EndpointKind.CLIENT, node.get_client_names_and_types_by_node),
        ):
            for service, types in ask_node(ask, name, namespace):
                for type_name in types:
                    yield EndpointInfo(full_name(name, namespace), kind, service, type_name)


def _report(profile: Any) -> QosReport:
    return QosReport(
        profile.reliability.name,
        profile.durability.name,
        profile.history.name,
        profile.depth,
        str(profile.lifespan),
        str(profile.deadline),
        profile.liveliness.name,
        str(profile.liveliness_lease_duration),
    )
