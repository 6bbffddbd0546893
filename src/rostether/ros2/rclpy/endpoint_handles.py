"""The topics and services of a node of a ROS 2 graph over rclpy."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Unpack

from rostether.errors import GraphError, ServiceUnavailableError
from rostether.graph.ports import OnMessages, ServiceHandler, SubscribeOptions
from rostether.graph.publisher_handle import PublisherHandle, check_same_type
from rostether.mechanisms.tasks import cancel_all
from rostether.msgdef.interface import ANY_TYPE, MessageType, ServiceType
from rostether.ros2.endpoint_info import EndpointKind
from rostether.ros2.listed_client import ListedClient
from rostether.ros2.parameters.ros2_membership import Ros2Membership
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.publication import RclpyPublication
from rostether.ros2.rclpy.service_client import DISCOVERY_S, SERVICE_POLL_INTERVAL_S, RclpyServiceClient
from rostether.ros2.rclpy.service_server import RclpyServiceServer
from rostether.ros2.rclpy.subscription import RclpySubscriber
from rostether.ros2.rclpy.type_conflicts import CHECK_INTERVAL_S, TypeConflicts
from rostether.ros2.types.type_support import ServiceSupport

# How often subscribers search for new publishers if rclpy does not report them; users do not notice 0.2 s.
PUBLISHER_POLL_INTERVAL_S = 0.2


class RclpyEndpoints(Ros2Membership):
    """The part of an `RclpyGraph` that creates the endpoints of its node, and ends them with the node."""

    def __init__(self, own: OwnNode, namespace: str, remappings: Mapping[str, str]) -> None:
        super().__init__(own.name, namespace, remappings)
        self._own = own
        self._publications: dict[str, RclpyPublication] = {}
        self._subscribers: set[RclpySubscriber] = set()
        self._servers: dict[str, RclpyServiceServer] = {}
        self._clients: dict[tuple[str, str], RclpyServiceClient] = {}
        # The number of handles that list each client; clients without handles exist as long as the node.
        self._listed: Counter[tuple[str, str]] = Counter()
        # Endpoints with the same name are created and ended one at a time.
        self._lock = asyncio.Lock()
        self._polling: asyncio.Task[None] | None = None
        self._checking = asyncio.ensure_future(self._check_types())

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> PublisherHandle[RclpyPublication]:
        """Advertise a topic. `queue_bytes` has no effect: the middleware's queues are limited in messages.

        Raises UnknownTypeError for a type whose package is not installed, TypeMismatchError if this process
        uses the topic with another type, InvalidNameError.
        """
        self._check_open()
        name = self.resolve(topic)
        support = self._own.types.message(message_type)
        async with self._lock:
            publication = self._publications.get(name)
            if publication is None:
                publication = RclpyPublication(self._own, name, message_type, support, latch=latch)
                await self._own.thread.run(publication.open)
                self._publications[name] = publication
            else:
                check_same_type(name, publication.type, message_type)
            return PublisherHandle(publication, self._end_publication)

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> RclpySubscriber:
        """Subscribe. `ANY_MESSAGE` uses the type of the first publisher.

        Raises the same errors as `advertise`.
        """
        self._check_open()
        name = self.resolve(topic)
        subscriber = RclpySubscriber(
            self._own, name, message_type, on_messages, options, on_close=self._end_subscriber
        )
        await self._own.thread.run(subscriber.open)
        self._subscribers.add(subscriber)
        if subscriber.needs_polling and self._polling is None:
            self._polling = asyncio.ensure_future(self._poll_publishers())
        return subscriber

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> RclpyServiceServer:
        """Offer a service. A call whose handler fails gets no answer; /rosout has the reason.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        self._check_open()
        name = self.resolve(service)
        support = self._own.types.service(service_type)
        async with self._lock:
            if name in self._servers:
                raise GraphError(f"this node already offers the service {name}; choose another name")
            server = RclpyServiceServer(self._own, name, support, handler, self._end_server)
            await self._own.thread.run(server.open)
            self._servers[name] = server
        return server

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, TypeMismatchError,
        UnknownTypeError, InvalidNameError, SerializationError.
        """
        self._check_open()
        name = self.resolve(service)
        if service_type.name == ANY_TYPE:
            support = await self._learn_service(name)
        else:
            support = self._own.types.service(service_type)
        async with self._lock:
            client = await self._client(name, support)
        return await client.call(request, timeout_s)

    async def list_client(self, service: str, service_type: ServiceType) -> ListedClient:
        """Appear in the graph as a client of a service until the handle closes, even if it never calls.

        Raises UnknownTypeError, TypeMismatchError, InvalidNameError.
        """
        self._check_open()
        name = self.resolve(service)
        support = self._own.types.service(service_type)
        key = (name, support.name)
        async with self._lock:
            await self._client(name, support)
            self._listed[key] += 1
        return ListedClient(lambda: self._unlist(key))

    async def _close_endpoints(self) -> None:
        await cancel_all(self._checking, *((self._polling,) if self._polling is not None else ()))
        await asyncio.gather(
            *(each.close() for each in list(self._servers.values())),
            *(each.close() for each in list(self._subscribers)),
            *(self._end_publication(each) for each in list(self._publications.values())),
        )
        clients = list(self._clients.values())
        self._clients.clear()
        for client in clients:
            await self._own.thread.run(client.end)

    async def _client(self, service: str, support: ServiceSupport) -> RclpyServiceClient:
        """Return the only client of a service and type; call it while holding the lock."""
        client = self._clients.get((service, support.name))
        if client is None:
            client = RclpyServiceClient(self._own, service, support)
            await self._own.thread.run(client.open)
            self._clients[service, support.name] = client
        return client

    async def _unlist(self, key: tuple[str, str]) -> None:
        async with self._lock:
            self._listed[key] -= 1
            if self._listed[key]:
                return
            del self._listed[key]
            client = self._clients.pop(key, None)
            # `close` has already ended it with the node.
            if client is not None:
                await self._own.thread.run(client.end)

    async def _learn_service(self, service: str) -> ServiceSupport:
        loop = asyncio.get_running_loop()
        deadline_s = loop.time() + DISCOVERY_S
        while not (types := await self._own.thread.run(lambda: self._own.service_types(service))):
            if loop.time() >= deadline_s:
                raise ServiceUnavailableError(f"no node offers the service {service}; start its node")
            await asyncio.sleep(SERVICE_POLL_INTERVAL_S)
        return self._own.types.service_by_name(types[0])

    async def _poll_publishers(self) -> None:
        while True:
            await asyncio.sleep(PUBLISHER_POLL_INTERVAL_S)
            for subscriber in list(self._subscribers):
                if subscriber.needs_polling:
                    await self._own.thread.run(subscriber.adapt)

    async def _check_types(self) -> None:
        conflicts = TypeConflicts(self._own)
        while True:
            await asyncio.sleep(CHECK_INTERVAL_S)
            used = {
                EndpointKind.PUBLISHER: {
                    (each.topic, each.support.name) for each in self._publications.values()
                },
                EndpointKind.SUBSCRIPTION: {
                    (each.topic, each.type_name) for each in self._subscribers if each.type_name
                },
            }
            await self._own.thread.run(partial(conflicts.report, used))

    async def _end_publication(self, publication: RclpyPublication) -> None:
        async with self._lock:
            # In the meantime, a new handle may exist, or the node may have ended.
            is_open = self._publications.get(publication.topic) is publication
            if is_open and (publication.handle_count == 0 or self._closing is not None):
                del self._publications[publication.topic]
                publication.send_rest()
                await self._own.thread.run(publication.close)

    async def _end_subscriber(self, subscriber: RclpySubscriber) -> None:
        self._subscribers.discard(subscriber)
        await self._own.thread.run(subscriber.end)

    async def _end_server(self, server: RclpyServiceServer) -> None:
        async with self._lock:
            del self._servers[server.service]
            await self._own.thread.run(server.end)
