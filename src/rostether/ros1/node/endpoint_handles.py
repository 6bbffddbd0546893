"""The endpoints of one node, and its two servers.

Requests of the slave API do not name the node, so each node has its own servers.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Iterable
from functools import partial
from typing import Unpack

from rostether.errors import GraphError
from rostether.graph.ports import Level, OnMessages, ServiceHandler, SubscribeOptions
from rostether.msgdef.interface import ANY_TYPE, MessageType, ServiceType
from rostether.ros1.environment import RosEnvironment, format_uri
from rostether.ros1.node.master_client import MasterClient
from rostether.ros1.node.own_registrations import UNREGISTER_TIMEOUT_S, OwnKind, OwnRegistrations
from rostether.ros1.node.parameters import ParameterWatches
from rostether.ros1.node.publication import Publication, Publisher
from rostether.ros1.node.service_server import ServiceConnection, ServiceServer
from rostether.ros1.node.slave_api import slave_dispatch
from rostether.ros1.node.subscriber_connection import SubscriberConnection
from rostether.ros1.node.subscription import Subscription
from rostether.ros1.node.tcpros_listener import TcprosListener
from rostether.ros1.own_host import check_own_host
from rostether.ros1.xmlrpc_server import XmlRpcServer
from rostether.xmlrpc.values import XmlRpcValue


class Endpoints:
    """All endpoints of a node; keeps them registered.

    `report` receives log lines about the node; `on_shutdown` is called when the node is asked to shut down.
    """

    def __init__(
        self,
        master: MasterClient,
        environment: RosEnvironment,
        *,
        report: Callable[[Level, str], None],
        on_shutdown: Callable[[str], None],
    ) -> None:
        self.node_name = master.caller_id
        self.master_uri = master.uri
        self._master = master
        self._environment = environment
        self._report = report
        self._on_shutdown = on_shutdown
        self._publications: dict[str, Publication] = {}
        self._subscriptions: dict[str, list[Subscription]] = {}
        self._services: dict[str, ServiceServer] = {}
        self._listener = TcprosListener(
            self._accept_subscriber, self._accept_client, report, environment.admission, environment.limits
        )
        self._server = XmlRpcServer(
            slave_dispatch(self),
            hosts=environment.listen_hosts,
            advertised_host=environment.advertised_host,
            admission=environment.admission,
            limits=environment.limits,
            own_names=environment.own_names,
        )
        self._is_open = False
        self.watches: ParameterWatches
        self._registrations: OwnRegistrations

    async def open(self) -> None:
        """Start both servers. Raises ConfigError, GraphError."""
        await self._listener.start(self._environment.listen_hosts)
        await self._server.start()
        self.watches = ParameterWatches(self._master, self.node_uri)
        host, port = self.tcpros_address
        self._registrations = OwnRegistrations(
            self._master,
            node_uri=self.node_uri,
            service_uri=format_uri(host, port, scheme="rosrpc"),
            on_publishers=self._add_publishers,
            register_more=self.watches.subscribe_again,
            on_replaced=self._on_shutdown,
        )
        self._is_open = True

    def start_watch(self, interval_s: float) -> None:
        """Check the node's host name now, and its registrations every `interval_s`."""
        self._registrations.start_watch(interval_s)
        check_own_host(self._environment.advertised_host, partial(self._report, Level.WARN))

    @property
    def node_uri(self) -> str:
        """The URI of the node's XML-RPC server."""
        return self._server.uri

    @property
    def tcpros_address(self) -> tuple[str, int]:
        """Host and port for TCPROS connections to the node."""
        return self._environment.advertised_host, self._listener.port

    @property
    def publications(self) -> Iterable[Publication]:
        """The publications of the node."""
        return self._publications.values()

    @property
    def subscriptions(self) -> Iterable[Subscription]:
        """The subscriptions of the node."""
        return [each for topic in self._subscriptions.values() for each in topic]

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> Publisher:
        """Publish on a topic. Raises TypeMismatchError, GraphError."""
        publication = self._publications.get(topic)
        if publication is not None:
            publication.share(message_type, latch=latch)
            return Publisher(publication, self._release_publication)
        publication = Publication(
            topic,
            message_type,
            node_name=self.node_name,
            report=self._report,
            latch=latch,
            queue_bytes=queue_bytes,
        )
        return await self.add_publication(publication)

    async def add_publication(self, publication: Publication) -> Publisher:
        """Register a publication and return a handle to it. Raises GraphError."""
        self._publications[publication.topic] = publication
        publisher = Publisher(publication, self._release_publication)
        try:
            await self._registrations.add(OwnKind.PUBLISHER, publication.topic, publication.type.name)
        except GraphError:
            await publisher.close()
            raise
        return publisher

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> Subscription:
        """Subscribe to a topic. Raises GraphError."""
        subscription = Subscription(
            topic,
            message_type,
            on_messages,
            node_name=self.node_name,
            own_uri=self.node_uri,
            report=self._report,
            on_close=self._release_subscription,
            limits=self._environment.limits,
            **options,
        )
        together = self._subscriptions.setdefault(topic, [])
        together.append(subscription)
        # The master stores one type per topic: the known one is better than `*`.
        known = next((each.type.name for each in together if each.type.name != ANY_TYPE), ANY_TYPE)
        try:
            await self._registrations.add(OwnKind.SUBSCRIBER, topic, known)
        except GraphError:
            await subscription.close()
            raise
        return subscription

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> ServiceServer:
        """Offer a service. Raises GraphError if this node already offers it, or the master refuses."""
        if service in self._services:
            raise GraphError(f"this node already offers the service {service}; choose another name")
        server = ServiceServer(
            service,
            service_type,
            handler,
            node_name=self.node_name,
            on_close=self._release_service,
            limits=self._environment.limits,
        )
        self._services[service] = server
        try:
            await self._registrations.add(OwnKind.SERVICE, service)
        except GraphError:
            await server.close()
            raise
        return server

    async def close(self) -> None:
        """Unregister everything and end all connections."""
        if self._is_open:
            await asyncio.gather(self._registrations.close(), self._close_watches())
            await self._close_all()
        await self._listener.close()
        await self._server.close()

    async def _close_watches(self) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(UNREGISTER_TIMEOUT_S):
                await self.watches.close()

    async def _close_all(self) -> None:
        await asyncio.gather(
            *(each.close() for each in self.subscriptions),
            *(each.close() for each in list(self._services.values())),
            *(each.close() for each in self._publications.values()),
        )

    def set_publishers(self, topic: str, uris: list[str]) -> None:
        """Apply the master's list of a topic's publishers."""
        for subscription in self._subscriptions.get(topic, ()):
            subscription.set_publishers(uris)

    def update_param(self, name: str, value: XmlRpcValue) -> bool:
        """Apply a parameter's new value; return False if it is not watched."""
        return self.watches.update(name, value)

    def shut_down(self, reason: str) -> None:
        """Leave the graph on a shutdown request."""
        self._on_shutdown(reason)

    def _add_publishers(self, topic: str, uris: list[str]) -> None:
        for subscription in self._subscriptions.get(topic, ()):
            subscription.add_publishers(uris)

    def _accept_subscriber(
        self, fields: dict[str, str], transport: asyncio.Transport
    ) -> SubscriberConnection:
        publication = self._publications.get(fields["topic"])
        if publication is None:
            raise GraphError(f"[{self.node_name}] is not a publisher of [{fields['topic']}]")
        return publication.accept(fields, transport)

    def _accept_client(self, fields: dict[str, str], transport: asyncio.Transport) -> ServiceConnection:
        server = self._services.get(fields["service"])
        if server is None:
            raise GraphError(f"[{self.node_name}] is not a provider of [{fields['service']}]")
        return server.accept(fields, transport)

    async def _release_publication(self, publication: Publication) -> None:
        del self._publications[publication.topic]
        await asyncio.gather(
            self._registrations.remove(OwnKind.PUBLISHER, publication.topic), publication.close()
        )

    async def _release_subscription(self, subscription: Subscription) -> None:
        together = self._subscriptions[subscription.topic]
        together.remove(subscription)
        if not together:
            del self._subscriptions[subscription.topic]
            await self._registrations.remove(OwnKind.SUBSCRIBER, subscription.topic)

    async def _release_service(self, server: ServiceServer) -> None:
        del self._services[server.service]
        await self._registrations.remove(OwnKind.SERVICE, server.service)
