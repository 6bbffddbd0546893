"""One subscription of this node: a link to each publisher of its topic."""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Awaitable, Callable, Container, Mapping, Sequence
from typing import Unpack

from rostether.graph.callbacks import call_safely
from rostether.graph.ports import Level, OnMessages, SubscribeOptions
from rostether.msgdef.interface import ANY_MESSAGE, ANY_TYPE, MessageType
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.node.publisher_connection import PublisherConnection, PublisherLink
from rostether.ros1.tcpros_connection import ConnectionRecord
from rostether.tcpros.handshake import check_publisher, subscriber_fields, type_of


class Subscription:
    """Implements `graph.ports.Subscriber`; `own_uri` is the URI of this node.

    Each has its own connections, even if one node subscribes to a topic twice: so each can pause, and each
    new one receives the latched message.
    """

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        *,
        node_name: str,
        own_uri: str = "",
        report: Callable[[Level, str], None],
        on_close: Callable[[Subscription], Awaitable[None]],
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
        **options: Unpack[SubscribeOptions],
    ) -> None:
        self.topic = topic
        self.type = message_type
        self._node_name = node_name
        self._report = report
        self._on_messages = on_messages
        self._on_connection = options.get("on_connection")
        self._on_close = on_close
        self._limits = limits
        self._skipped_uri = own_uri if options.get("skip_own") else ""
        self._skip_nodes: Container[str] = options.get("skip_nodes", ())
        self._learns_type = options.get("one_type", False) and message_type.name == ANY_TYPE
        self._links: dict[str, PublisherLink] = {}
        self._ending_links: dict[PublisherLink, asyncio.Task[None]] = {}  # of publishers that have ended
        tcp_nodelay = options.get("tcp_nodelay", True)
        self._request = subscriber_fields(topic, message_type, caller_id=node_name, tcp_nodelay=tcp_nodelay)
        self._what = f"on_messages of {topic}"
        self._is_paused = False
        self._is_closed = False

    @property
    def connections(self) -> list[PublisherConnection]:
        """The open connections."""
        links = (*self._links.values(), *self._ending_links)
        return [link.connection for link in links if link.connection is not None]

    @property
    def publisher_count(self) -> int:
        """How many publishers are connected now."""
        return len(self.connections)

    def set_publishers(self, uris: Sequence[str]) -> None:
        """Connect to new publishers; disconnect from ended ones after their last message."""
        for uri in self._links.keys() - set(uris):
            link = self._links.pop(uri)
            self._ending_links[link] = task = asyncio.ensure_future(link.drain())
            task.add_done_callback(functools.partial(self._forget, link))
        self.add_publishers(uris)

    def add_publishers(self, uris: Sequence[str]) -> None:
        """Connect to new publishers.

        A publisher that is not in `uris` stays connected: the answer to a registration may be older than the
        last update, or come from a master that has just restarted and knows few publishers.
        """
        for uri in uris:
            if uri not in self._links and uri != self._skipped_uri and not self._is_closed:
                self._links[uri] = self._ending_link(uri) or PublisherLink(
                    uri,
                    caller_id=self._node_name,
                    request=self._request,
                    accept=self._accept,
                    report=self._report_problem,
                )

    def _ending_link(self, uri: str) -> PublisherLink | None:
        # A second connection beside one that is still open would deliver messages twice.
        for link in self._ending_links:
            if link.uri == uri and link.is_connected:
                self._ending_links.pop(link).cancel()
                return link
        return None

    def _forget(self, link: PublisherLink, _task: asyncio.Task[None]) -> None:
        self._ending_links.pop(link, None)

    def pause(self) -> None:
        """Stop reading from publishers, so that they queue on their side."""
        self._is_paused = True
        for connection in self.connections:
            connection.pause()

    def resume(self) -> None:
        """Read again."""
        self._is_paused = False
        for connection in self.connections:
            connection.resume()

    async def close(self) -> None:
        """Unsubscribe. Idempotent; no callback runs after it returns."""
        if self._is_closed:
            return
        self._is_closed = True
        links = [*self._links.values(), *self._ending_links]
        self._links.clear()
        await asyncio.gather(*self._ending_links.values(), *(link.close() for link in links))
        await self._on_close(self)

    def _accept(self, uri: str, fields: dict[str, str], transport: asyncio.Transport) -> PublisherConnection:
        node_name = fields.get("callerid", "")
        linked = [link.connection for link in self._links.values() if link.connection is not None]
        if self._learns_type and not any(each.node_name not in self._skip_nodes for each in linked):
            self.type = ANY_MESSAGE
        check_publisher(fields, self.topic, self.type)
        if self._learns_type and node_name not in self._skip_nodes:
            self.type = type_of(fields)
        connection = PublisherConnection(
            transport,
            ConnectionRecord(transport, peer=uri, topic=self.topic, direction="i"),
            self._receiver_of(fields),
            self._limits.message_bytes,
            node_name=node_name,
        )
        if self._is_paused:
            connection.pause()
        return connection

    def _receiver_of(self, fields: Mapping[str, str]) -> OnMessages:
        """Report a connection; return the function that receives its messages."""
        own: OnMessages | None = None
        if self._on_connection is not None:
            own = call_safely(f"on_connection of {self.topic}", self._on_connection, fields)
        on_messages, node_name = own or self._on_messages, fields.get("callerid", "")

        def deliver(payloads: Sequence[bytes]) -> None:
            # A publisher that is omitted stays connected: otherwise it would be asked repeatedly.
            if not self._is_closed and node_name not in self._skip_nodes:
                call_safely(self._what, on_messages, payloads)

        return deliver

    def _report_problem(self, problem: str) -> None:
        self._report(Level.WARN, f"cannot subscribe to {self.topic}: {problem}")
