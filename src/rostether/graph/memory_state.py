"""The shared state of the nodes of one in-memory graph: endpoints, parameters, logs and the time."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

from rostether.errors import UnknownNameError
from rostether.graph.log_message import LogRecord
from rostether.graph.memory_parameters import MemoryParameters
from rostether.graph.memory_services import MemoryServiceServer
from rostether.graph.memory_topics import MemoryPublisher, MemorySubscriber
from rostether.graph.node_membership import NodeMembership
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.graph.ros_clock import wall_time
from rostether.msgdef.interface import ANY_TYPE
from rostether.rostime import Time

# The number of logs kept for later reads; a test reads a handful.
MAX_LOGS = 1000


class MemoryState:
    """The shared state; `logs` keeps the latest logs."""

    def __init__(self, now: Callable[[], Time] = wall_time) -> None:
        self.now = now
        self.logs: deque[LogRecord] = deque(maxlen=MAX_LOGS)
        self.parameters = MemoryParameters()
        self.nodes: dict[str, NodeMembership] = {}
        self._publishers: list[MemoryPublisher] = []
        self._subscribers: list[MemorySubscriber] = []
        self._services: dict[str, MemoryServiceServer] = {}
        self._change_events: set[asyncio.Event] = set()

    def leave(self, node: NodeMembership) -> None:
        """Forget a node."""
        if self.nodes.get(node.node_name) is node:
            del self.nodes[node.node_name]
        self.notify()

    def add_publisher(self, publisher: MemoryPublisher) -> None:
        """Connect a publisher with the topic's subscribers."""
        self._publishers.append(publisher)
        for subscriber in self._subscribers:
            if subscriber.topic == publisher.topic:
                publisher.connect(subscriber)
        self.notify()

    def add_subscriber(self, subscriber: MemorySubscriber) -> None:
        """Connect a subscriber with the topic's publishers."""
        self._subscribers.append(subscriber)
        for publisher in self._publishers:
            if publisher.topic == subscriber.topic:
                publisher.connect(subscriber)
        self.notify()

    def add_service(self, server: MemoryServiceServer) -> None:
        """Offer a service; a later offer replaces an earlier one, as with a ROS 1 master."""
        self._services[server.service] = server
        self.notify()

    def remove(self, endpoint: MemoryPublisher | MemorySubscriber | MemoryServiceServer) -> None:
        """Forget an endpoint."""
        if isinstance(endpoint, MemoryPublisher):
            self._publishers.remove(endpoint)
        elif isinstance(endpoint, MemorySubscriber):
            self._subscribers.remove(endpoint)
        elif self._services.get(endpoint.service) is endpoint:
            del self._services[endpoint.service]
        self.notify()

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

    def watch_changes(self) -> asyncio.Event:
        """Return an event that is set after each change, until `unwatch_changes`."""
        event = asyncio.Event()
        self._change_events.add(event)
        return event

    def unwatch_changes(self, event: asyncio.Event) -> None:
        """Forget an event."""
        self._change_events.discard(event)

    def notify(self) -> None:
        """Set the events of `watch_changes`."""
        for event in self._change_events:
            event.set()

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
