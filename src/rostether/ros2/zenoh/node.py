"""A node of a ROS 2 graph over zenoh: the graph port by rmw_zenoh's conventions."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import AsyncExitStack
from functools import partial
from typing import Unpack

from rostether.graph.log_message import encode_log
from rostether.graph.ports import Level, OnMessages, ParamValue, ServiceHandler, Snapshot, SubscribeOptions
from rostether.graph.publisher_handle import PublisherHandle
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.ros2.clock import NodeClock
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind, QosReport
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.naming import logger_name, type_of_dds_name, validate_topic_name
from rostether.ros2.parameters.graph_parameters import GraphParameters
from rostether.ros2.parameters.ros2_membership import Ros2Membership
from rostether.ros2.parameters.services import ParameterServices
from rostether.ros2.parameters.store import ParameterStore
from rostether.ros2.type_description import learn_type
from rostether.ros2.types.type_hash import TYPE_HASH_NOT_SUPPORTED
from rostether.ros2.zenoh.attachment import gid_of
from rostether.ros2.zenoh.endpoint_handles import ZenohEndpoints
from rostether.ros2.zenoh.entities import NodeEntities
from rostether.ros2.zenoh.publication import ZenohPublication
from rostether.ros2.zenoh.service_server import ZenohServiceServer
from rostether.ros2.zenoh.shared_session import SharedSession
from rostether.ros2.zenoh.subscription import ZenohSubscriber
from rostether.ros2.zenoh.tokens import ADMIN_SPACE, Token, TokenKind, parse_token
from rostether.rostime import Time

_KINDS = {
    TokenKind.PUBLISHER: EndpointKind.PUBLISHER,
    TokenKind.SUBSCRIBER: EndpointKind.SUBSCRIPTION,
    TokenKind.SERVER: EndpointKind.SERVER,
    TokenKind.CLIENT: EndpointKind.CLIENT,
}

# A router on this machine answers in milliseconds.
DOMAINS_TIMEOUT_S = 1.0

_log = logging.getLogger("rostether.ros2")


class ZenohGraph(Ros2Membership):
    """Implements `graph.ports.Graph`; made by `ZenohSession.join`."""

    def __init__(
        self,
        session: SharedSession,
        node_name: str,
        namespace: str,
        remappings: Mapping[str, str],
        parameters: Mapping[str, ParamValue],
    ) -> None:
        super().__init__(node_name, namespace, remappings)
        self._session = session
        self._endpoints = ZenohEndpoints(NodeEntities(session, node_name), report=self._report)
        store = ParameterStore(parameters)
        self._parameters = GraphParameters(store, self)
        self._parameter_services = ParameterServices(store, self)
        self._clock = NodeClock(store, self)

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> PublisherHandle[ZenohPublication]:
        """Advertise a topic.

        `queue_bytes` limits the messages that wait while a link is full; zenoh itself queues 1 MiB. Raises
        TypeMismatchError, UnknownTypeError, InvalidNameError.
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
        **options: Unpack[SubscribeOptions],
    ) -> ZenohSubscriber:
        """Subscribe. `ANY_MESSAGE` accepts every type; `on_connection` is called for each publisher.

        Raises TypeMismatchError, UnknownTypeError, InvalidNameError.
        """
        self._check_open()
        return self._endpoints.subscribe(
            self._resolve_ros2(topic),
            message_type,
            on_messages,
            options=options,
            describe=partial(learn_type, self, self._session.types),
        )

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ZenohServiceServer:
        """Offer a service. A handler that raises RostetherError fails the call with that error's text.

        Raises GraphError if this node already offers the service, UnknownTypeError, InvalidNameError.
        """
        self._check_open()
        return self._endpoints.advertise_service(self._resolve_ros2(service), service_type, handler)

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        UnknownTypeError, InvalidNameError, SerializationError.
        """
        self._check_open()
        return await self._endpoints.call_service(
            self._resolve_ros2(service), service_type, request, timeout_s=timeout_s
        )

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """Appear in the graph as a client of a service.

        Raises UnknownTypeError, TypeMismatchError, InvalidNameError.
        """
        self._check_open()
        return self._endpoints.list_client(self._resolve_ros2(service), service_type)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        # On the way, rosgraph_msgs/Log becomes rcl_interfaces/msg/Log, which has no sequence number.
        message = encode_log(
            sequence=0, stamp=self.now(), level=level, node_name=logger_name(self.node_name), text=text
        )
        self._endpoints.publish_log(message)

    def now(self) -> Time:
        """Return ROS time: the wall clock, or /clock under use_sim_time (zero before its first message)."""
        return self._clock.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        return self._session.graph.snapshot()

    async def endpoints(self) -> list[EndpointInfo]:
        """Return all known endpoints of topics and services."""
        return list_endpoints(self._session.graph.all_endpoints())

    async def distribution(self) -> str:
        """Return "humble" if an endpoint of another session has no type hash, else an empty string."""
        own = self._session.session_id
        tokens = (token for _, token in self._session.graph.all_endpoints() if token.session_id != own)
        is_humble = any(token.type_hash == TYPE_HASH_NOT_SUPPORTED for token in tokens)
        return "humble" if is_humble else ""

    async def other_domains(self) -> list[int]:
        """Return the other domains of this zenoh network that have nodes, sorted."""
        key = f"{ADMIN_SPACE}/*/*/*/*/{TokenKind.NODE.value}/**"
        texts = await self._session.query_tokens(key, DOMAINS_TIMEOUT_S)
        found = {token.domain_id for token in map(parse_token, texts) if token is not None}
        return sorted(found - {self._session.domain_id})

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change."""
        return self._session.graph.changes(self._closed)

    async def open(self) -> None:
        """Appear in the graph; `ZenohSession.join` calls it. Raises GraphError."""
        self._endpoints.open()
        await self._clock.open()
        await self._parameter_services.open()

    async def _end(self) -> None:
        try:
            async with AsyncExitStack() as stack:
                # The stack closes in reverse order: the users of the endpoints before the endpoints.
                stack.push_async_callback(self._endpoints.close)
                stack.push_async_callback(self._parameter_services.close)
                stack.push_async_callback(self._clock.close)
                stack.push_async_callback(self._parameters.close)
        finally:
            self._session.nodes.discard(self)

    def _resolve_ros2(self, name: str) -> str:
        return validate_topic_name(self.resolve(name))

    def _report(self, level: Level, text: str) -> None:
        _log.log(level.number_in_tens, "%s: %s", self.node_name, text)
        self.log(level, text)


def list_endpoints(tokens: Iterable[tuple[str, Token]]) -> list[EndpointInfo]:
    """Return the endpoints of tokens, without tokens of nodes."""
    return [_describe(text, token) for text, token in tokens if token.kind in _KINDS]


def _describe(text: str, token: Token) -> EndpointInfo:
    qos = token.qos
    return EndpointInfo(
        token.node_name,
        _KINDS[token.kind],
        token.name,
        type_of_dds_name(token.type) or token.type,
        token.type_hash,
        gid_of(text),
        QosReport(qos.reliability.name, qos.durability.name, qos.history.name, qos.depth),
    )
