"""One topic that a node publishes: its zenoh publisher, its token, and the handles on it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence

import zenoh
from zenoh import ext

from rostether.errors import SerializationError, TypeMismatchError
from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.ros2.naming import dds_name
from rostether.ros2.qos import DEFAULT_QOS, LATCHED_QOS, Qos
from rostether.ros2.type_support import MessageSupport
from rostether.ros2.zenoh.attachment import ATTACHMENT, GID_BYTES, gid_of
from rostether.ros2.zenoh.entities import NodeEntities
from rostether.ros2.zenoh.mismatches import Mismatches
from rostether.ros2.zenoh.session import LiveToken
from rostether.ros2.zenoh.tokens import Kind, Token, data_key

STALL_NS = 800_000
"""A put that takes this long waited for room: zenoh waits 1 ms for it before it drops a message."""

MAX_STALLS = 5
"""Waits in one batch before the rest of it is dropped: what one full link may hold up the loop."""

RELIEF_S = 0.01
"""What a source pauses after a batch that met a full link: at 1 Gbit/s a link empties in this time."""

Report = Callable[[Level, str], None]


class Publication:
    """Converts every batch to CDR and puts it to zenoh, which sends it to whoever subscribes."""

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        support: MessageSupport,
        *,
        node: NodeEntities,
        report: Report,
        latch: bool = False,
        qos: Qos | None = None,
    ) -> None:
        self.topic = topic
        self.type = message_type
        self.dropped_count = 0
        self.handle_count = 0
        self.gids: set[bytes] = set()
        self._support = support
        self._convert = support.converter.to_cdr
        self._node = node
        self._report = report
        self._qos = qos or (LATCHED_QOS if latch else DEFAULT_QOS)
        self._type_name = dds_name(support.name)
        self._key = data_key(node.session.domain_id, topic, self._type_name, support.type_hash)
        self._mismatches = Mismatches(topic, support, report)
        self._sequence = 0
        self._is_open = True
        self._has_warned = False
        # zenoh's word comes when somebody subscribes, also who has no token; a token may come before it.
        self._is_matched = False
        self._subscribers: list[Token] = []
        self._declare()
        node.session.graph.listen(Kind.SUBSCRIBER, topic, self._look)
        self._look()

    @property
    def subscriber_count(self) -> int:
        """How many subscribers of our type there are."""
        return len(self._subscribers)

    def share(self, message_type: MessageType, *, latch: bool) -> None:
        """Let one more handle publish here. Raises TypeMismatchError when it has another type."""
        if message_type.md5sum != self.type.md5sum:
            raise TypeMismatchError(
                f"this node publishes {self.topic} as {self.type.name} already, not as {message_type.name}: "
                "choose another topic"
            )
        if latch and not self._qos.is_latching:
            self._undeclare()
            self._qos = LATCHED_QOS
            self._declare()

    def publish(self, payloads: Sequence[bytes]) -> bool:
        """Put a batch; False when a link is full, see `Publisher.publish_raw`."""
        if not (self._is_matched or self._subscribers or self._qos.is_latching):
            return self._is_open
        convert, put, gid, sequence = self._convert, self._publisher.put, self._gid, self._sequence
        pack, clock = ATTACHMENT.pack, time.time_ns
        stalls = 0
        now = clock()
        for index, payload in enumerate(payloads):
            try:
                cdr = convert(payload)
            except SerializationError as error:
                self._refuse(error)
                continue
            sequence += 1
            before = now
            put(cdr, attachment=pack(sequence, now, GID_BYTES, gid))
            now = clock()
            if now - before > STALL_NS:
                stalls += 1
                if stalls >= MAX_STALLS:
                    self.dropped_count += len(payloads) - index - 1
                    break
        self._sequence = sequence
        self._is_open = stalls < 2  # One may be the scheduler's.
        return self._is_open

    async def drained(self, timeout_s: float) -> None:
        """Wait until a link that was full has had time to send."""
        if not self._is_open:
            await asyncio.sleep(min(RELIEF_S, timeout_s))
            self._is_open = True

    def close(self) -> None:
        """Unadvertise."""
        self._node.session.graph.unlisten(Kind.SUBSCRIBER, self.topic, self._look)
        self._subscribers = []
        self._undeclare()

    def _declare(self) -> None:
        session = self._node.session.zenoh
        if self._qos.is_latching:
            self._matching = None
            self._publisher: zenoh.Publisher | ext.AdvancedPublisher = ext.declare_advanced_publisher(
                session,
                self._key,
                congestion_control=zenoh.CongestionControl.DROP,
                cache=ext.CacheConfig(max_samples=self._qos.depth),
                publisher_detection=True,
            )
        else:
            publisher = session.declare_publisher(
                self._key, congestion_control=zenoh.CongestionControl.DROP, reliability=zenoh.Reliability.RELIABLE
            )
            self._matching = publisher.declare_matching_listener(
                zenoh.handlers.Callback(self._match, indirect=False)
            )
            self._is_matched = publisher.matching_status.matching
            self._publisher = publisher
        self._token: LiveToken = self._node.declare(
            Kind.PUBLISHER, self.topic, self._type_name, self._support.type_hash, self._qos
        )
        self._gid = gid_of(self._token.text)
        self.gids.add(self._gid)

    def _undeclare(self) -> None:
        self._token.withdraw()
        self._publisher.undeclare()

    def _match(self, status: zenoh.MatchingStatus) -> None:
        # In a thread of zenoh's: one assignment, which needs no lock.
        self._is_matched = status.matching

    def _look(self) -> None:
        ends = self._node.session.graph.endpoints(Kind.SUBSCRIBER, self.topic)
        self._subscribers = [
            end for end in ends if end.type == self._type_name and end.type_hash == self._support.type_hash
        ]
        self._mismatches.tell(ends)

    def _refuse(self, error: SerializationError) -> None:
        self.dropped_count += 1
        if not self._has_warned:
            self._has_warned = True
            self._report(Level.WARN, f"{self.topic}: a message cannot be put into ROS 2's form: {error}")


class Publisher:
    """A `graph.ports.Publisher`: one handle on a publication."""

    def __init__(self, publication: Publication, on_close: Callable[[Publication], None]) -> None:
        self._publication = publication
        self._on_close = on_close
        self._is_closed = False
        publication.handle_count += 1

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self._publication.topic

    @property
    def type(self) -> MessageType:
        """The advertised type."""
        return self._publication.type

    @property
    def subscriber_count(self) -> int:
        """How many subscribers there are now."""
        return self._publication.subscriber_count

    @property
    def dropped_count(self) -> int:
        """How many messages did not fit their type or met a full link; zenoh does not tell of others."""
        return self._publication.dropped_count

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        """Publish the payloads in order; False asks the caller to await `drained`."""
        return self._is_closed or self._publication.publish(payloads)

    async def drained(self, timeout_s: float) -> None:
        """Wait until a link that was full has had time to send."""
        await self._publication.drained(timeout_s)

    async def close(self) -> None:
        """Unadvertise, with the last handle. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            self._publication.handle_count -= 1
            if self._publication.handle_count == 0:
                self._on_close(self._publication)
