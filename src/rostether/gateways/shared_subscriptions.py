"""One subscription to a topic on the graph, shared by all clients of a gateway that want it.

Each client gets the messages unchanged, with the type that the publisher reported; a client that subscribes
late gets the last messages of latched publishers. No publisher is paused: each client has its own bounded
queue.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

from rostether.errors import GraphError
from rostether.graph.callbacks import call_safely
from rostether.graph.message_stream import LearnedTypes
from rostether.graph.ports import Graph, OnMessages, Subscriber
from rostether.msgdef.interface import ANY_MD5SUM, ANY_MESSAGE, ANY_TYPE, MessageType
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore

# The limit of stored publishers and latched messages of one topic; peers may invent names of nodes.
MAX_CONNECTIONS = 256


class PublisherConnection:
    """One publisher of a topic, according to its connection header."""

    def __init__(self, topic: str, fields: Mapping[str, str], types: LearnedTypes) -> None:
        self.topic = topic
        self.type = MessageType(
            fields.get("type", ANY_TYPE),
            fields.get("md5sum", ANY_MD5SUM),
            fields.get("message_definition", ""),
        )
        self.node_name = fields.get("callerid", "")
        self.is_latching = fields.get("latching") == "1"
        self._fields = fields
        self._types = types

    @cached_property
    def codec(self) -> Codec:
        """The codec of its messages. Raises UnknownTypeError, DefinitionError, TypeMismatchError."""
        return self._types.codec(self._fields)


class Batch:
    """Messages that arrived together from one publisher; `forms` caches conversions for all subscribers."""

    __slots__ = ("connection", "forms", "payloads")

    def __init__(self, connection: PublisherConnection, payloads: Sequence[bytes]) -> None:
        self.connection = connection
        self.payloads = payloads
        self.forms: dict[Any, Any] = {}


OnBatch: TypeAlias = Callable[[Batch], None]
OnConnection: TypeAlias = Callable[[PublisherConnection], None]


class SharedSubscription:
    """One subscriber's share; made by `SharedSubscriptions.subscribe`."""

    def __init__(self, source: _Source, on_batch: OnBatch, on_connection: OnConnection | None) -> None:
        self.topic = source.topic
        self._source = source
        self._on_batch = on_batch
        self._on_connection = on_connection
        self._is_closed = False

    async def close(self) -> None:
        """Unsubscribe; the last one ends the subscription on the graph. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            await self._source.remove(self)

    def deliver(self, batch: Batch) -> None:
        """Deliver a batch; an error of the callback is reported and ignored."""
        if not self._is_closed:
            call_safely(f"subscriber of {self.topic}", self._on_batch, batch)

    def report_connection(self, connection: PublisherConnection) -> None:
        """Report a publisher."""
        if self._on_connection is not None and not self._is_closed:
            call_safely(f"on_connection of {self.topic}", self._on_connection, connection)


class SharedSubscriptions:
    """All topics that the clients of a gateway subscribe to, each with one subscription on the graph."""

    def __init__(self, graph: Graph, store: TypeStore) -> None:
        self.types = LearnedTypes(store)
        self._graph = graph
        self._sources: dict[str, _Source] = {}

    async def subscribe(
        self, topic: str, on_batch: OnBatch, on_connection: OnConnection | None = None
    ) -> SharedSubscription:
        """Subscribe to a topic of any type; `on_connection` is called for a publisher before its first batch.

        Raises InvalidNameError, GraphError.
        """
        name = self._graph.resolve(topic)
        source = self._sources.get(name)
        if source is None:
            source = self._sources[name] = _Source(self._graph, name, self.types, self._forget)
        share = SharedSubscription(source, on_batch, on_connection)
        try:
            await source.add(share)
        except BaseException:
            await share.close()
            raise
        return share

    async def close(self) -> None:
        """End all subscriptions."""
        await asyncio.gather(*(source.close() for source in list(self._sources.values())))

    def _forget(self, source: _Source) -> None:
        if self._sources.get(source.topic) is source:
            del self._sources[source.topic]


class _Source:
    """One topic on the graph, and its sharing subscribers."""

    def __init__(
        self, graph: Graph, topic: str, types: LearnedTypes, on_end: Callable[[_Source], None]
    ) -> None:
        self.topic = topic
        self._connections: dict[str, PublisherConnection] = {}
        self._graph = graph
        self._types = types
        self._on_end = on_end
        self._shares: tuple[SharedSubscription, ...] = ()
        self._latched: dict[str, Batch] = {}
        self._last: PublisherConnection | None = None
        self._opening = asyncio.ensure_future(self._open())
        # Waiting subscribers get the error. If there are none, this keeps asyncio from logging it.
        self._opening.add_done_callback(lambda task: task.cancelled() or task.exception())
        self._has_ended = False

    async def add(self, share: SharedSubscription) -> None:
        connections, latched = list(self._connections.values()), list(self._latched.values())
        self._shares = (*self._shares, share)
        await asyncio.shield(self._opening)
        for connection in connections:
            share.report_connection(connection)
        if not latched:
            return
        publishers = await self._publishers()
        for batch in latched:
            # A latched message is not valid after the end of its publisher. If a newer one has arrived, the
            # share already has it.
            node_name = batch.connection.node_name
            if (publishers is None or node_name in publishers) and self._latched.get(node_name) is batch:
                share.deliver(batch)

    async def remove(self, share: SharedSubscription) -> None:
        self._shares = tuple(each for each in self._shares if each is not share)
        if not self._shares:
            await self.close()

    async def close(self) -> None:
        if self._has_ended:
            return
        self._has_ended = True
        self._on_end(self)
        # Let an unfinished subscription complete: it cannot be canceled halfway.
        await asyncio.wait([self._opening])
        if not self._opening.cancelled() and self._opening.exception() is None:
            await self._opening.result().close()

    async def _publishers(self) -> Sequence[str] | None:
        try:
            info = (await self._graph.snapshot()).topics.get(self.topic)
        except GraphError:
            return None
        return info.publishers if info is not None else ()

    async def _open(self) -> Subscriber:
        return await self._graph.subscribe(
            self.topic, ANY_MESSAGE, self._deliver_from_last, on_connection=self._add_connection
        )

    def _add_connection(self, fields: Mapping[str, str]) -> OnMessages:
        connection = PublisherConnection(self.topic, dict(fields), self._types)
        for table in (self._connections, self._latched):
            table.pop(connection.node_name, None)
            while len(table) >= MAX_CONNECTIONS:
                del table[next(iter(table))]
        self._connections[connection.node_name] = self._last = connection
        for share in self._shares:
            share.report_connection(connection)
        return lambda payloads: self._deliver(connection, payloads)

    def _deliver_from_last(self, payloads: Sequence[bytes]) -> None:
        # For graphs that do not distinguish publishers.
        if self._last is not None:
            self._deliver(self._last, payloads)

    def _deliver(self, connection: PublisherConnection, payloads: Sequence[bytes]) -> None:
        if not payloads:
            return
        if connection.is_latching:
            self._latched[connection.node_name] = Batch(connection, payloads[-1:])
        batch = Batch(connection, payloads)
        for share in self._shares:
            share.deliver(batch)
