"""A ROS graph inside one process, without sockets: tests and previews join it instead of a master."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Unpack

from rostether.errors import GraphError, ServiceUnavailableError, UnknownNameError
from rostether.graph.log_message import LOG_TYPE, ROSOUT, LogRecord, encode_log
from rostether.graph.memory_endpoints import MemoryPublisher, MemoryServiceServer, MemorySubscriber
from rostether.graph.memory_parameters import MemoryParameters
from rostether.graph.node_membership import NodeMembership
from rostether.graph.parameter_watch import ParameterWatch
from rostether.graph.ports import (
    NAME_TAKEN,
    Level,
    OnMessages,
    ParamValue,
    ServiceEntry,
    ServiceHandler,
    Snapshot,
    SubscribeOptions,
    TopicEntry,
)
from rostether.graph.publisher_handle import check_same_type
from rostether.graph.ros_clock import wall_time
from rostether.graph.snapshots import ChangeSignal
from rostether.mechanisms.block_end import Closable
from rostether.msgdef.interface import ANY_TYPE, MessageType, ServiceType
from rostether.names.graph_name import join, validate_name
from rostether.rostime import Time

# The number of logs kept for later reads; a test reads a handful.
MAX_LOGS = 1000


class MemoryNetwork:
    """One in-memory graph: endpoints, parameters, the latest `logs` and the time; `join` is a `JoinGraph`."""

    def __init__(self, now: Callable[[], Time] = wall_time) -> None:
        self.now = now
        self.logs: deque[LogRecord] = deque(maxlen=MAX_LOGS)
        self.parameters = MemoryParameters()
        self.changed = ChangeSignal()
        self.nodes: dict[str, MemoryGraph] = {}
        self._publishers: list[MemoryPublisher] = []
        self._subscribers: list[MemorySubscriber] = []
        self._services: dict[str, MemoryServiceServer] = {}

    async def join(
        self, node_name: str, *, namespace: str = "/", remappings: Mapping[str, str] | None = None
    ) -> MemoryGraph:
        """Join as `node_name`; a node that has the name leaves. Raises InvalidNameError."""
        full_name = join(namespace, validate_name(node_name))
        if before := self.nodes.get(full_name):
            await before.close(NAME_TAKEN)
        graph = MemoryGraph(self, full_name, namespace, remappings or {})
        self.nodes[full_name] = graph
        self.changed.notify()
        return graph

    def leave(self, node: MemoryGraph) -> None:
        """Forget a node."""
        if self.nodes.get(node.node_name) is node:
            del self.nodes[node.node_name]
        self.changed.notify()

    def add_publisher(self, publisher: MemoryPublisher) -> None:
        """Connect a publisher with the topic's subscribers."""
        self._publishers.append(publisher)
        for subscriber in self._subscribers:
            if subscriber.topic == publisher.topic:
                publisher.connect(subscriber)
        self.changed.notify()

    def add_subscriber(self, subscriber: MemorySubscriber) -> None:
        """Connect a subscriber with the topic's publishers."""
        self._subscribers.append(subscriber)
        for publisher in self._publishers:
            if publisher.topic == subscriber.topic:
                publisher.connect(subscriber)
        self.changed.notify()

    def add_service(self, server: MemoryServiceServer) -> None:
        """Offer a service; a later offer replaces an earlier one, as with a ROS 1 master."""
        self._services[server.service] = server
        self.changed.notify()

    def remove(self, endpoint: MemoryPublisher | MemorySubscriber | MemoryServiceServer) -> None:
        """Forget an endpoint."""
        if isinstance(endpoint, MemoryPublisher):
            self._publishers.remove(endpoint)
        elif isinstance(endpoint, MemorySubscriber):
            self._subscribers.remove(endpoint)
        elif self._services.get(endpoint.service) is endpoint:
            del self._services[endpoint.service]
        self.changed.notify()

    def service(self, name: str) -> MemoryServiceServer:
        """Return the server of a service. Raises UnknownNameError."""
        try:
            return self._services[name]
        except KeyError:
            raise UnknownNameError(f"no node offers the service {name}; start its node") from None

    def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        names = {each.topic for each in self._publishers} | {each.topic for each in self._subscribers}
        return Snapshot(
            nodes=tuple(sorted(self.nodes)),
            topics={name: self._topic_info(name) for name in sorted(names)},
            services={
                name: ServiceEntry(name, (server.node_name,), server.type.name)
                for name, server in sorted(self._services.items())
            },
        )

    def _topic_info(self, name: str) -> TopicEntry:
        publishers = [each for each in self._publishers if each.topic == name]
        subscribers = [each for each in self._subscribers if each.topic == name]
        types = [each.type.name for each in publishers] + [each.type.name for each in subscribers]
        return TopicEntry(
            name,
            next((each for each in types if each != ANY_TYPE), ANY_TYPE),
            tuple(sorted({each.node_name for each in publishers})),
            tuple(sorted({each.node_name for each in subscribers})),
        )


class MemoryGraph(NodeMembership):
    """Implements `Graph`; created by `MemoryNetwork.join`."""

    def __init__(
        self, network: MemoryNetwork, node_name: str, namespace: str, remappings: Mapping[str, str]
    ) -> None:
        super().__init__(node_name, namespace, remappings)
        self._network = network
        # Everything that ends with the node.
        self._handles: dict[Closable, None] = {}
        self._log_sequence = 0
        self._leaving = asyncio.Event()
        self._rosout = self._add_publisher(ROSOUT, LOG_TYPE, latch=True)

    async def advertise(
        self, topic: str, message_type: MessageType, *, latch: bool = False, queue_bytes: int | None = None
    ) -> MemoryPublisher:
        """Advertise a topic. Raises TypeMismatchError, InvalidNameError, GraphError."""
        self._check_open()
        name = self.resolve(topic)
        for handle in self._handles:
            if isinstance(handle, MemoryPublisher) and handle.topic == name:
                check_same_type(name, handle.type, message_type)
        return self._add_publisher(name, message_type, latch=latch, queue_bytes=queue_bytes)

    async def subscribe(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        **options: Unpack[SubscribeOptions],
    ) -> MemorySubscriber:
        """Subscribe to a topic. Raises InvalidNameError, GraphError."""
        self._check_open()
        subscriber = MemorySubscriber(
            self.resolve(topic),
            message_type,
            self.node_name,
            on_messages,
            on_close=self._release,
            options=options,
        )
        self._handles[subscriber] = None
        self._network.add_subscriber(subscriber)
        return subscriber

    async def advertise_service(
        self, service: str, service_type: ServiceType, handler: ServiceHandler
    ) -> MemoryServiceServer:
        """Offer a service. Raises GraphError if this node already offers it."""
        self._check_open()
        name = self.resolve(service)
        if any(isinstance(each, MemoryServiceServer) and each.service == name for each in self._handles):
            raise GraphError(f"this node already offers the service {name}; choose another name")
        server = MemoryServiceServer(name, service_type, self.node_name, handler, self._release)
        self._handles[server] = None
        self._network.add_service(server)
        return server

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service. Raises the errors of `Graph.call_service`."""
        self._check_open()
        try:
            server = self._network.service(self.resolve(service))
        except UnknownNameError as error:
            raise ServiceUnavailableError(str(error)) from None
        return await server.call(service_type, request, timeout_s)

    async def get_param(self, name: str) -> ParamValue:
        """Return a parameter's value. Raises UnknownNameError."""
        return self._network.parameters.get(self.resolve(name))

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter."""
        self._network.parameters.set(self.resolve(name), value)

    async def delete_param(self, name: str) -> None:
        """Delete a parameter. Raises UnknownNameError."""
        self._network.parameters.delete(self.resolve(name))

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set."""
        return self._network.parameters.get_or_none(self.resolve(name)) is not None

    async def search_param(self, name: str) -> str | None:
        """Return the full name of the nearest parameter of that name, as rospy does, else None."""
        if name.startswith(("/", "~")):
            return self.resolve(name) if await self.has_param(name) else None
        parts = [part for part in self.node_name.split("/") if part]
        first = name.partition("/")[0]
        for depth in range(len(parts), -1, -1):
            prefix = "".join(f"/{part}" for part in parts[:depth])
            if await self.has_param(f"{prefix}/{first}"):
                return f"{prefix}/{name}"
        return None

    async def list_params(self) -> list[str]:
        """Return the full names of all parameters, sorted."""
        return self._network.parameters.names()

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> ParameterWatch:
        """Call back with the value now and after every change."""
        self._check_open()
        watch = self._network.parameters.watch(self.resolve(name), on_change)
        self._handles[watch] = None
        return watch

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout, and keep it in the network's `logs`."""
        self._network.logs.append(LogRecord(self.node_name, level, text))
        self._log_sequence += 1
        message = encode_log(
            sequence=self._log_sequence,
            stamp=self.now(),
            level=level,
            node_name=self.node_name,
            text=text,
            topics=[each.topic for each in self._handles if isinstance(each, MemoryPublisher)],
        )
        self._rosout.publish_raw([message])

    def now(self) -> Time:
        """Return the network's time."""
        return self._network.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        return self._network.snapshot()

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change, until the node leaves."""
        return self._network.changed.follow(self._network.snapshot, self._leaving)

    def _release(self, endpoint: MemoryPublisher | MemorySubscriber | MemoryServiceServer) -> None:
        self._handles.pop(endpoint, None)
        self._network.remove(endpoint)

    async def _end(self) -> None:
        self._leaving.set()
        await asyncio.gather(*(handle.close() for handle in list(self._handles)))
        self._network.leave(self)

    def _add_publisher(
        self, topic: str, message_type: MessageType, *, latch: bool, queue_bytes: int | None = None
    ) -> MemoryPublisher:
        publisher = MemoryPublisher(
            topic, message_type, self.node_name, latch=latch, queue_bytes=queue_bytes, on_close=self._release
        )
        self._handles[publisher] = None
        self._network.add_publisher(publisher)
        return publisher
