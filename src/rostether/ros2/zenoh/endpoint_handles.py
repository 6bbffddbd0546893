"""The publishers, subscribers, service servers and service clients of one node, over zenoh."""

from __future__ import annotations

import asyncio
from collections import Counter

from rostether.errors import GraphError, ServiceUnavailableError, TypeMismatchError
from rostether.graph.log_message import LOG_TYPE, ROSOUT
from rostether.graph.ports import OnMessages, Report, ServiceHandler, SubscribeOptions
from rostether.graph.publisher_handle import PublisherHandle
from rostether.msgdef.interface import ANY_TYPE, MessageType, ServiceType
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.naming import dds_name, type_of_dds_name
from rostether.ros2.qos import ROSOUT_QOS
from rostether.ros2.types.type_support import ServiceSupport
from rostether.ros2.zenoh.described_types import Describe
from rostether.ros2.zenoh.entities import NodeEntities
from rostether.ros2.zenoh.publication import ZenohPublication
from rostether.ros2.zenoh.service_client import ZenohServiceClient
from rostether.ros2.zenoh.service_server import ZenohServiceServer
from rostether.ros2.zenoh.shared_session import LiveToken
from rostether.ros2.zenoh.subscription import SubscriberCallbacks, ZenohSubscriber
from rostether.ros2.zenoh.tokens import Token, TokenKind

# The time to wait until an unknown service is announced: 1 ms on one machine, longer through several routers.
ANNOUNCEMENT_S = 0.2

# The maximum number of unlisted service clients that a node keeps; a board's sketch has only a few.
MAX_CLIENTS = 256


class ZenohEndpoints:
    """Creates the endpoints of a node, and ends them with the node; names are fully resolved."""

    def __init__(self, node: NodeEntities, *, report: Report) -> None:
        self._node = node
        self._report = report
        self._publications: dict[str, ZenohPublication] = {}
        self._subscribers: set[ZenohSubscriber] = set()
        self._servers: dict[str, ZenohServiceServer] = {}
        self._clients: dict[tuple[str, str], ZenohServiceClient] = {}
        # The number of handles that list each client; clients without handles are kept up to `MAX_CLIENTS`.
        self._listed: Counter[tuple[str, str]] = Counter()
        self._node_token: LiveToken | None = None
        self._rosout: ZenohPublication | None = None

    def open(self) -> None:
        """Appear in the graph, with /rosout."""
        self._node_token = self._node.declare_node()
        support = self._node.session.types.message(LOG_TYPE)
        self._rosout = ZenohPublication(
            ROSOUT, LOG_TYPE, support, node=self._node, report=self._report, latch=True, qos=ROSOUT_QOS
        )
        # Closing a handle to /rosout must not end this publisher.
        self._rosout.handle_count = 1
        self._publications[ROSOUT] = self._rosout

    def publish_log(self, message: bytes) -> None:
        """Publish a message on /rosout."""
        if self._rosout is not None:
            self._rosout.publish([message])

    def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool, queue_bytes: int | None
    ) -> PublisherHandle[ZenohPublication]:
        """Advertise a topic. Raises TypeMismatchError, UnknownTypeError."""
        publication = self._publications.get(topic)
        if publication is None:
            support = self._node.session.types.message(message_type)
            publication = ZenohPublication(
                topic,
                message_type,
                support,
                node=self._node,
                report=self._report,
                latch=latch,
                queue_bytes=queue_bytes,
            )
            self._publications[topic] = publication
        else:
            publication.share(message_type, latch=latch)
        return PublisherHandle(publication, self._release_publication)

    def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        *,
        options: SubscribeOptions,
        describe: Describe,
    ) -> ZenohSubscriber:
        """Subscribe to a topic. Raises TypeMismatchError, UnknownTypeError."""
        is_any = message_type.name == ANY_TYPE
        on_connection = options.get("on_connection")
        callbacks = SubscriberCallbacks(
            on_messages, on_connection, self._subscribers.discard, self._report, describe
        )
        subscriber = ZenohSubscriber(
            topic,
            None if is_any else self._node.session.types.message(message_type),
            callbacks,
            node=self._node,
            own_gids=(lambda: self._own_gids(topic)) if options.get("skip_own") else None,
            skip_nodes=options.get("skip_nodes", ()),
            one_type=options.get("one_type", False),
        )
        self._subscribers.add(subscriber)
        return subscriber

    def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ZenohServiceServer:
        """Offer a service.

        Raises GraphError if this node already offers it, TypeMismatchError, UnknownTypeError.
        """
        if service in self._servers:
            raise GraphError(f"this node already offers the service {service}; choose another name")
        support = self._node.session.types.service(service_type)
        server = ZenohServiceServer(service, support, handler, node=self._node, on_close=self._release_server)
        self._servers[service] = server
        return server

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None
    ) -> bytes:
        """Call a service. Raises the errors of `Graph.call_service`."""
        servers = await self._servers_of(service)
        if service_type.name == ANY_TYPE:
            support = self._node.session.types.service_by_name(_type_of(servers[0]))
        else:
            support = self._node.session.types.service(service_type)
        _check_type(service, support, servers)
        return await self._client(service, support).call(request, timeout_s)

    def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """List a client of a service until the handle closes, even if it never calls.

        Raises UnknownTypeError, TypeMismatchError.
        """
        support = self._node.session.types.service(service_type)
        self._client(service, support)
        key = (service, support.name)
        self._listed[key] += 1
        return ListedClient(lambda: self._unlist(key))

    async def close(self) -> None:
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
        graph = self._node.session.graph
        if not graph.endpoints(TokenKind.SERVER, service):
            changed = asyncio.Event()
            graph.listen(TokenKind.SERVER, service, changed.set)
            try:
                async with asyncio.timeout(ANNOUNCEMENT_S):
                    await changed.wait()
            except TimeoutError:
                pass
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
    type_name = dds_name(support.name)
    if any(each.type == type_name and each.type_hash == support.type_hash for each in servers):
        return
    other = servers[0]
    if other.type == type_name:
        raise TypeMismatchError(
            f"service {service} has another definition of {support.name} "
            f"({other.type_hash:.80}, not {support.type_hash}); set ROS_DISTRO to its distribution, "
            "or give its definition with --msg-path"
        )
    raise TypeMismatchError(
        f"service {service} has type {_type_of(other):.200}, not {support.name}; make both ends use one "
        "definition"
    )
