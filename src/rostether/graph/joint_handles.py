"""The handles of a joint graph: each represents one handle in every graph."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Container, Sequence

from rostether.graph.joint_handle import JointHandle
from rostether.graph.parameter_watch import NewValues
from rostether.graph.ports import (
    Graph,
    OnMessages,
    ParamValue,
    Publisher,
    ServiceHandler,
    ServiceServer,
    SubscribeOptions,
    Subscriber,
    Watch,
)
from rostether.msgdef.interface import MessageType, ServiceType


class JointPublisher(JointHandle[Publisher]):
    """A `graph.ports.Publisher` in several graphs."""

    def __init__(
        self, topic: str, message_type: MessageType, *, latch: bool, queue_bytes: int | None
    ) -> None:
        self.topic = topic
        self.type = message_type
        super().__init__(topic, self._advertise)
        self._latch = latch
        self._latched: bytes | None = None
        self._queue_bytes = queue_bytes

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now, in all graphs."""
        return sum(part.subscriber_count for part in self.parts.values())

    @property
    def dropped_count(self) -> int:
        """How many messages slow subscribers have lost so far, in all graphs."""
        return sum(part.dropped_count for part in self.parts.values())

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        """Queue the payloads in every graph; False when a subscriber in one of them is behind."""
        if self._latch and payloads and not self.is_closed:
            self._latched = payloads[-1]
        is_open = True
        for part in self.parts.values():
            is_open = part.publish_raw(payloads) and is_open
        return is_open

    async def drained(self, timeout_s: float) -> None:
        """Wait until all backlogs are low in all graphs, at most `timeout_s`; each call is one pause."""
        await asyncio.gather(*(part.drained(timeout_s) for part in self.parts.values()))

    async def _advertise(self, graph: Graph) -> Publisher:
        publisher = await graph.advertise(
            self.topic, self.type, latch=self._latch, queue_bytes=self._queue_bytes
        )
        if self._latched is not None:
            publisher.publish_raw([self._latched])
        return publisher


class JointSubscriber(JointHandle[Subscriber]):
    """A `graph.ports.Subscriber` in several graphs.

    Messages of nodes in several graphs come from the first graph only. Messages of relays between the graphs
    are ignored: the originals of these messages arrive directly.
    """

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        *,
        first: Graph,
        options: SubscribeOptions,
        joint_nodes: Container[str],
        relays: Container[str],
    ) -> None:
        self.topic = topic
        super().__init__(topic, self._subscribe)
        self._type = message_type
        self._on_messages = on_messages
        self._first = first
        self._options = options
        self._joint_nodes = joint_nodes
        self._relays = relays
        self._is_paused = False

    @property
    def publisher_count(self) -> int:
        """How many publishers are connected now, in all graphs."""
        return sum(part.publisher_count for part in self.parts.values())

    def pause(self) -> None:
        """Stop reading in every graph."""
        self._is_paused = True
        for part in self.parts.values():
            part.pause()

    def resume(self) -> None:
        """Read again."""
        self._is_paused = False
        for part in self.parts.values():
            part.resume()

    async def _subscribe(self, graph: Graph) -> Subscriber:
        is_first = graph is self._first
        options = self._options.copy()
        options["skip_own"] = options.get("skip_own", False) or not is_first
        skipped = options.get("skip_nodes", ()) if is_first else self._joint_nodes
        options["skip_nodes"] = _AnyOf(self._relays, skipped)
        subscriber = await graph.subscribe(self.topic, self._type, self._on_messages, **options)
        if self._is_paused:
            subscriber.pause()
        return subscriber


class _AnyOf:
    """The elements of several containers, which may change."""

    def __init__(self, *containers: Container[str]) -> None:
        self._containers = containers

    def __contains__(self, name: object) -> bool:
        return any(name in each for each in self._containers)


class JointServiceServer(JointHandle[ServiceServer]):
    """A `graph.ports.ServiceServer` in several graphs."""

    def __init__(self, service: str, service_type: ServiceType, handler: ServiceHandler) -> None:
        self.service = service
        super().__init__(
            f"service {service}", lambda graph: graph.advertise_service(service, service_type, handler)
        )


class UnlistedClient:
    """A `graph.ports.ServiceClient` in a graph that lists none."""

    async def close(self) -> None:
        """Do nothing: it was not listed."""


class JointWatch(JointHandle[Watch]):
    """A `graph.ports.Watch` in several graphs: reports the value of the first graph that has one."""

    def __init__(
        self, name: str, on_change: Callable[[ParamValue], None], order: Callable[[], Sequence[Graph]]
    ) -> None:
        super().__init__(f"parameter {name}", self._watch)
        self._name = name
        self._reports = NewValues(name, on_change)
        self._order = order
        self._values: dict[Graph, ParamValue] = {}
        self._is_started = False

    def start(self) -> None:
        """Report the current value, and later changes."""
        self._is_started = True
        self._reports.report(self._value())

    async def _watch(self, graph: Graph) -> Watch:
        def on_value(value: ParamValue) -> None:
            self._values[graph] = value
            if self._is_started and not self.is_closed:
                self._reports.report(self._value())

        return await graph.watch_param(self._name, on_value)

    def _value(self) -> ParamValue:
        values = (self._values.get(graph) for graph in self._order())
        return next((value for value in values if value is not None), None)
