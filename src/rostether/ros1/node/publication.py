"""One publication of this node: its connections, its latched message, and its handles."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence

from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES, PublicationFlow
from rostether.graph.ports import Level, Report
from rostether.graph.publisher_handle import PublisherHandle, check_same_type
from rostether.mechanisms.text import counted
from rostether.msgdef.interface import MessageType
from rostether.ros1.node.subscriber_connection import SubscriberConnection
from rostether.tcpros.handshake import check_subscriber, publisher_fields
from rostether.tcpros.header import encode_header
from rostether.tcpros.message_framing import encode_messages

# Called for a subscriber that has connected (True) or disconnected (False).
OnSubscriber = Callable[[SubscriberConnection, bool], None]


class Publication:
    """Sends every batch, encoded once, to all subscribers; each has its own queue."""

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        *,
        node_name: str,
        report: Report,
        latch: bool = False,
        queue_bytes: int | None = None,
    ) -> None:
        self.topic = topic
        self.type = message_type
        self.dropped_count = 0
        self.byte_count = 0
        self.connections: list[SubscriberConnection] = []
        self.handle_count = 0
        self.watchers: list[OnSubscriber] = []
        self._node_name = node_name
        self._report = report
        self._is_latching = latch
        self._queue_bytes = DEFAULT_QUEUE_BYTES if queue_bytes is None else queue_bytes
        self._flow = PublicationFlow()
        self._latched: bytes | None = None

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return len(self.connections)

    def share(self, message_type: MessageType, *, latch: bool) -> None:
        """Prepare for another handle. Raises TypeMismatchError if its type differs."""
        check_same_type(self.topic, self.type, message_type)
        if latch:
            self.latch()

    def latch(self) -> None:
        """Latch: keep the last message from now on."""
        self._is_latching = True

    def publish(self, payloads: Sequence[bytes]) -> bool:
        """Send or queue a batch; return False if a subscriber is behind, see `Publisher.publish_raw`."""
        if not payloads:
            return self._flow.is_open
        if self.connections:
            data = encode_messages(payloads)
            count = len(payloads)
            self.byte_count += len(data)
            for connection in self.connections:
                self.dropped_count += connection.send(data, count)
        if self._is_latching:
            self._latched = payloads[-1]
        return self._flow.is_open

    async def drained(self, timeout_s: float) -> None:
        """Wait until no subscriber is congested, at most `timeout_s`; after this time, the pause ends."""
        await self._flow.drained(timeout_s)

    def accept(self, fields: Mapping[str, str], transport: asyncio.Transport) -> SubscriberConnection:
        """Create the connection of a subscriber's header, and answer it. Raises TypeMismatchError."""
        check_subscriber(fields, self.topic, self.type)
        answer = publisher_fields(self.topic, self.type, caller_id=self._node_name, latch=self._is_latching)
        latched = b"" if self._latched is None else encode_messages([self._latched])
        connection = SubscriberConnection(
            transport,
            fields,
            self._flow,
            topic=self.topic,
            greeting=encode_header(answer) + latched,
            queue_bytes=self._queue_bytes,
            on_drop=self._report_drop,
            on_lost=self._forget,
        )
        self.connections.append(connection)
        # Watchers are called later, because they may send to the subscriber only after the handshake.
        asyncio.get_running_loop().call_soon(self._notify_watchers, connection, True)
        return connection

    async def close(self) -> None:
        """End all connections after their queued data was sent."""
        await asyncio.gather(*(connection.close() for connection in self.connections))

    def _forget(self, connection: SubscriberConnection) -> None:
        self.connections.remove(connection)
        self._notify_watchers(connection, False)

    def _notify_watchers(self, connection: SubscriberConnection, is_connected: bool) -> None:
        for watcher in list(self.watchers):
            watcher(connection, is_connected)

    def _report_drop(self, connection: SubscriberConnection) -> None:
        self._report(
            Level.WARN,
            f"{connection.record.peer} is too slow for {self.topic}; dropping its oldest messages "
            f"({self._queue_bytes} bytes queued, {counted(connection.dropped_count, 'message')} dropped so "
            "far)",
        )


class Publisher(PublisherHandle[Publication]):
    """A handle to a publication that also reports its connections."""

    @property
    def connections(self) -> list[SubscriberConnection]:
        """The subscribers that are connected now."""
        return list(self.publication.connections)

    def latch(self) -> None:
        """Latch: from now on, keep the last message for later subscribers."""
        self.publication.latch()

    def watch_subscribers(self, on_subscriber: OnSubscriber) -> None:
        """Call back for each subscriber that connects or disconnects, while the topic is advertised."""
        self.publication.watchers.append(on_subscriber)
