"""The topics and services of a node of a ROS 2 graph over zenoh."""

from __future__ import annotations

import asyncio
import logging
from abc import abstractmethod
from collections import Counter
from collections.abc import AsyncIterator, Mapping
from functools import partial
from typing import Unpack

from rostether.errors import GraphError, ServiceUnavailableError, TypeMismatchError
from rostether.graph.log_message import LOG_TYPE, ROSOUT, encode_log
from rostether.graph.ports import Level, OnMessages, ServiceHandler, Snapshot, SubscribeOptions
from rostether.graph.publisher_handle import PublisherHandle
from rostether.mechanisms.tasks import occurs_within
from rostether.msgdef.interface import ANY_TYPE, MessageType, ServiceType
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.naming import dds_name, logger_name, type_of_dds_name, validate_topic_name
from rostether.ros2.parameters.ros2_membership import Ros2Membership
from rostether.ros2.type_description import learn_type
from rostether.ros2.types.type_support import ServiceSupport
from rostether.ros2.zenoh.mismatches import is_of_type
from rostether.ros2.zenoh.publication import ZenohPublication
from rostether.ros2.zenoh.qos import ROSOUT_QOS
from rostether.ros2.zenoh.service_client import ZenohServiceClient
from rostether.ros2.zenoh.service_server import ZenohServiceServer
from rostether.ros2.zenoh.shared_session import LiveToken, NodeEntities, SharedSession
from rostether.ros2.zenoh.subscription import ZenohSubscriber
from rostether.ros2.zenoh.tokens import Token, TokenKind
from rostether.rostime import Time

# The time to wait until an unknown service is announced: 1 ms on one machine, longer through several routers.
ANNOUNCEMENT_S = 0.2

# The maximum number of unlisted service clients that a node keeps; a board's sketch has only a few.
MAX_CLIENTS = 256

_log = logging.getLogger("rostether.ros2")


class ZenohEndpoints(Ros2Membership):
    """The part of a `ZenohGraph` that creates the endpoints of its node, and ends them with the node."""

    def __init__(
        self, session: SharedSession, node_name: str, namespace: str, remappings: Mapping[str, str]
    ) -> None:
        super().__init__(node_name, namespace, remappings)
        self._session = session
        self._node = NodeEntities(session, node_name, self._report)
        self._publications: dict[str, ZenohPublication] = {}
        self._subscribers: set[ZenohSubscriber] = set()
        self._servers: dict[str, ZenohServiceServer] = {}
        self._clients: dict[tuple[str, str], ZenohServiceClient] = {}
        # The number of handles that list each client; clients without handles are kept up to `MAX_CLIENTS`.
        self._listed: Counter[tuple[str, str]] = Counter()
        self._node_token: LiveToken | None = None
        self._rosout: ZenohPublication | None = None

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> PublisherHandle[ZenohPublication]:
        """Advertise a topic.

        `queue_bytes` limits the messages that wait while a link is full; zenoh itself queues 1 MiB. Raises
        TypeMismatchError, UnknownTypeError, InvalidNameError.
        """
        name = self._resolve_open(topic)
        publication = self._publications.get(name)
        if publication is None:
            support = self._session.types.message(message_type)
            publication = self._publications[name] = ZenohPublication(
                name,
                message_type,
                support,
                node=self._node,
                latch=latch,
                queue_bytes=queue_bytes,
            )
        else:
            publication.share(message_type, latch=latch)
        return PublisherHandle(publication, self._release_publication)

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
        name = self._resolve_open(topic)
        types = self._session.types
        subscriber = ZenohSubscriber(
            name,
            None if message_type.name == ANY_TYPE else types.message(message_type),
            on_messages,
            options,
            node=self._node,
            describe=partial(learn_type, self, types),
            own_gids=lambda: self._own_gids(name),
            on_close=self._subscribers.discard,
        )
        self._subscribers.add(subscriber)
        return subscriber

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ZenohServiceServer:
        """Offer a service. A handler that raises RostetherError fails the call with that error's text.

        Raises GraphError if this node already offers the service, TypeMismatchError, UnknownTypeError,
        InvalidNameError.
        """
        name = self._resolve_open(service)
        if name in self._servers:
            raise GraphError(f"this node already offers the service {name}; choose another name")
        support = self._session.types.service(service_type)
        server = ZenohServiceServer(name, support, handler, node=self._node, on_close=self._release_server)
        self._servers[name] = server
        return server

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        UnknownTypeError, InvalidNameError, SerializationError.
        """
        name = self._resolve_open(service)
        servers = await self._servers_of(name)
        if service_type.name == ANY_TYPE:
            support = self._session.types.service_by_name(_type_of(servers[0]))
        else:
            support = self._session.types.service(service_type)
        _check_type(name, support, servers)
        return await self._client(name, support).call(request, timeout_s)

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """Appear in the graph as a client of a service until the handle closes, even if it never calls.

        Raises UnknownTypeError, TypeMismatchError, InvalidNameError.
        """
        name = self._resolve_open(service)
        support = self._session.types.service(service_type)
        self._client(name, support)
        key = (name, support.name)
        self._listed[key] += 1
        return ListedClient(lambda: self._unlist(key))

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        if self._rosout is not None:
            # On the way, rosgraph_msgs/Log becomes rcl_interfaces/msg/Log, which has no sequence number.
            name = logger_name(self.node_name)
            message = encode_log(sequence=0, stamp=self.now(), level=level, node_name=name, text=text)
            self._rosout.publish([message])

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        return self._session.graph.snapshot()

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change."""
        graph = self._session.graph
        return graph.changed.follow(graph.snapshot, self._closed)

    @abstractmethod
    def now(self) -> Time:
        """Return ROS time."""

    def _open_endpoints(self) -> None:
        """Appear in the graph, with /rosout."""
        self._node_token = self._node.declare_node()
        support = self._session.types.message(LOG_TYPE)
        self._rosout = ZenohPublication(
            ROSOUT, LOG_TYPE, support, node=self._node, latch=True, qos=ROSOUT_QOS
        )
        # Closing a handle to /rosout must not end this publisher.
        self._rosout.handle_count = 1
        self._publications[ROSOUT] = self._rosout

    async def _close_endpoints(self) -> None:
        """Close all endpoints, and withdraw the node from the graph."""
        await asyncio.gather(
            *(each.close() for each in list(self._subscribers)),
            *(each.close() for each in list(self._servers.values())),
        )
        publications = list(self._publications.values())
        self._publications.clear()
        await asyncio.gather(*(publication.close() for publication in publications))
        self._rosout = None
        for client in self._clients.values():
            client.close()
        self._clients.clear()
        if self._node_token is not None:
            self._node_token.withdraw()
            self._node_token = None

    def _report(self, level: Level, text: str) -> None:
        _log.log(level.number_in_tens, "%s: %s", self.node_name, text)
        self.log(level, text)

    def _resolve_open(self, name: str) -> str:
        """Return the full name of a topic or service. Raises GraphError after the node has left."""
        self._check_open()
        return validate_topic_name(self.resolve(name))

    def _client(self, service: str, support: ServiceSupport) -> ZenohServiceClient:
        key = (service, support.name)
        client = self._clients.get(key)
        if client is None:
            unlisted = [each for each in self._clients if each not in self._listed]
            if len(unlisted) >= MAX_CLIENTS:
                self._clients.pop(unlisted[0]).close()
            client = self._clients[key] = ZenohServiceClient(service, support, node=self._node)
        return client

    async def _unlist(self, key: tuple[str, str]) -> None:
        self._listed[key] -= 1
        if self._listed[key]:
            return
        del self._listed[key]
        client = self._clients.pop(key, None)
        # `close` has already ended it with the node.
        if client is not None:
            client.close()

    async def _servers_of(self, service: str) -> list[Token]:
        graph = self._session.graph
        if not graph.endpoints(TokenKind.SERVER, service):
            changed = asyncio.Event()
            graph.listen(TokenKind.SERVER, service, changed.set)
            try:
                await occurs_within(changed, ANNOUNCEMENT_S)
            finally:
                graph.unlisten(TokenKind.SERVER, service, changed.set)
        servers = graph.endpoints(TokenKind.SERVER, service)
        if not servers:
            raise ServiceUnavailableError(f"no node offers the service {service}; start its node")
        return servers

    def _own_gids(self, topic: str) -> set[bytes]:
        publication = self._publications.get(topic)
        return set() if publication is None else publication.gids

    async def _release_publication(self, publication: ZenohPublication) -> None:
        if self._publications.pop(publication.topic, None) is not None:
            await publication.close()

    def _release_server(self, server: ZenohServiceServer) -> None:
        self._servers.pop(server.service, None)


def _type_of(server: Token) -> str:
    return type_of_dds_name(server.type) or server.type


def _check_type(service: str, support: ServiceSupport, servers: list[Token]) -> None:
    if any(is_of_type(each, support) for each in servers):
        return
    other = servers[0]
    if other.type == dds_name(support.name):
        raise TypeMismatchError(
            f"service {service} has another definition of {support.name} "
            f"({other.type_hash:.80}, not {support.type_hash}); set ROS_DISTRO to its distribution, "
            "or give its definition with --msg-path"
        )
    raise TypeMismatchError(
        f"service {service} has type {_type_of(other):.200}, not {support.name}; make both ends use one "
        "definition"
    )
