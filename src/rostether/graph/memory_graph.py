"""The graph port in memory: one node of a `MemoryNetwork`."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Unpack

from rostether.errors import GraphError, ServiceUnavailableError, UnknownNameError
from rostether.graph.log_message import LOG_TYPE, ROSOUT, LogRecord, encode_log
from rostether.graph.memory_parameters import MemoryWatch
from rostether.graph.memory_services import MemoryServiceServer
from rostether.graph.memory_state import MemoryState
from rostether.graph.memory_topics import MemoryPublisher, MemorySubscriber
from rostether.graph.node_membership import NodeMembership
from rostether.graph.ports import Level, OnMessages, ParamValue, ServiceHandler, Snapshot, SubscribeOptions
from rostether.graph.publisher_handle import check_same_type
from rostether.mechanisms.block_end import Closable
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.rostime import Time


class MemoryGraph(NodeMembership):
    """Implements `Graph`; created by `MemoryNetwork.join`."""

    def __init__(
        self, state: MemoryState, node_name: str, namespace: str, remappings: Mapping[str, str]
    ) -> None:
        super().__init__(node_name, namespace, remappings)
        self._state = state
        # Everything that ends with the node.
        self._handles: dict[Closable, None] = {}
        self._log_sequence = 0
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
        self._state.add_subscriber(subscriber)
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
        self._state.add_service(server)
        return server

    async def call_service(
        self, service: str, service_type: ServiceType, request: bytes, *, timeout_s: float | None = None
    ) -> bytes:
        """Call a service. Raises the errors of `Graph.call_service`."""
        self._check_open()
        try:
            server = self._state.service(self.resolve(service))
        except UnknownNameError as error:
            raise ServiceUnavailableError(str(error)) from None
        return await server.call(service_type, request, timeout_s)

    async def get_param(self, name: str) -> ParamValue:
        """Return a parameter's value. Raises UnknownNameError."""
        return self._state.parameters.get(self.resolve(name))

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter."""
        self._state.parameters.set(self.resolve(name), value)

    async def delete_param(self, name: str) -> None:
        """Delete a parameter. Raises UnknownNameError."""
        self._state.parameters.delete(self.resolve(name))

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set."""
        return self._state.parameters.get_or_none(self.resolve(name)) is not None

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
        return self._state.parameters.names()

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> MemoryWatch:
        """Call back with the value now and after every change."""
        self._check_open()
        watch = self._state.parameters.watch(self.resolve(name), on_change)
        self._handles[watch] = None
        return watch

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout, and keep it in the network's `logs`."""
        self._state.logs.append(LogRecord(self.node_name, level, text))
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
        return self._state.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        return self._state.snapshot()

    async def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change, until the node leaves."""
        event = self._state.watch_changes()
        try:
            latest = None
            while self._closing is None:
                event.clear()
                snapshot = self._state.snapshot()
                if snapshot != latest:
                    latest = snapshot
                    yield snapshot
                else:
                    await event.wait()
        finally:
            self._state.unwatch_changes(event)

    def _release(self, endpoint: MemoryPublisher | MemorySubscriber | MemoryServiceServer) -> None:
        self._handles.pop(endpoint, None)
        self._state.remove(endpoint)

    async def _end(self) -> None:
        await asyncio.gather(*(handle.close() for handle in list(self._handles)))
        self._state.leave(self)

    def _add_publisher(
        self, topic: str, message_type: MessageType, *, latch: bool, queue_bytes: int | None = None
    ) -> MemoryPublisher:
        publisher = MemoryPublisher(
            topic, message_type, self.node_name, latch=latch, queue_bytes=queue_bytes, on_close=self._release
        )
        self._handles[publisher] = None
        self._state.add_publisher(publisher)
        return publisher
