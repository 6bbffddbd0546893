"""One topic that a node publishes: its zenoh publisher, its token, and the handles on it."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Protocol, cast

import zenoh
from zenoh import ext

from rostether.errors import SerializationError, TypeMismatchError
from rostether.graph.flow_control import (
    DEFAULT_QUEUE_BYTES,
    HIGH_WATER_BYTES,
    PublicationFlow,
    SubscriberFlow,
)
from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.ros2.naming import dds_name
from rostether.ros2.qos import DEFAULT_QOS, LATCHED_QOS, Qos
from rostether.ros2.type_support import MessageSupport
from rostether.ros2.zenoh.attachment import ATTACHMENT, GID_BYTES, gid_of
from rostether.ros2.zenoh.configuration import WAIT_BEFORE_DROP_US
from rostether.ros2.zenoh.entities import NodeEntities
from rostether.ros2.zenoh.mismatches import Mismatches
from rostether.ros2.zenoh.session import LiveToken
from rostether.ros2.zenoh.tokens import Kind, Token, data_key

STALL_NS = 300_000
"""A put that takes this long has waited for room; others take a hundredth of it."""

MAX_STALLS = 2
"""Such puts before the rest of a batch waits: one may be the scheduler's doing."""

DROP_NS = WAIT_BEFORE_DROP_US * 1000
"""A put that takes this long has waited in vain, and zenoh has dropped its message."""

RELIEF_S = 0.001
"""How long what waits is left to itself then: a batch of 64 KiB has gone after 0.5 ms at 1 Gbit/s."""

SLOW_RELIEF_S = 0.5
"""The same after a wait in vain: who hangs holds up the loop for a sixth of the time at most."""

Report = Callable[[Level, str], None]


class _Putting(Protocol):
    def put(self, payload: bytes, *, attachment: bytes) -> object: ...

    def undeclare(self) -> object: ...


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
        queue_bytes: int | None = None,
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
        # What waits while links are full: payloads as they came.
        self._limit_bytes = DEFAULT_QUEUE_BYTES if queue_bytes is None else queue_bytes
        self._waiting: deque[bytes] = deque()
        self._waiting_bytes = 0
        self._flow = PublicationFlow()
        self._backlog = SubscriberFlow(self._flow, min(HIGH_WATER_BYTES, self._limit_bytes // 2))
        self._relief: asyncio.TimerHandle | None = None
        self._relief_s = RELIEF_S
        self._has_warned = False
        # zenoh's word comes when somebody subscribes, also who has no token; a token may come before it.
        self._is_matched = False
        self._subscribers: list[Token] = []
        self._declare()
        node.session.graph.listen(Kind.SUBSCRIBER, topic, self._look)
        self._look()

    @property
    def subscriber_count(self) -> int:
        """How many subscribers of our type there are; none before zenoh has a way to them."""
        return len(self._subscribers) if self._is_matched or self._qos.is_latching else 0

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
        """Put a batch, or queue it while a link is full, see `Publisher.publish_raw`."""
        if not (self._is_matched or self._subscribers or self._qos.is_latching):
            return True
        if not self._waiting:
            done = self._put(payloads)
            if done == len(payloads):
                return self._flow.is_open
            payloads = payloads[done:]
        self._queue(payloads)
        return self._flow.is_open

    async def drained(self, timeout_s: float) -> None:
        """Wait until what waits for a full link is little; if it is not by then, it pauses nobody more."""
        await self._flow.drained(timeout_s)

    def close(self) -> None:
        """Unadvertise; what waits goes first."""
        if self._relief is not None:
            self._relief.cancel()
        waiting, self._waiting = list(self._waiting), deque()
        while waiting:
            waiting = waiting[self._put(waiting) :]
        self._backlog.end()
        self._node.session.graph.unlisten(Kind.SUBSCRIBER, self.topic, self._look)
        self._subscribers = []
        self._undeclare()

    def _put(self, payloads: Sequence[bytes]) -> int:
        """Put messages until links are full; returns how many are done with."""
        convert, put, gid, sequence = self._convert, self._publisher.put, self._gid, self._sequence
        pack, clock = ATTACHMENT.pack, time.time_ns
        done = stalls = 0
        self._relief_s = RELIEF_S
        now = clock()
        for payload in payloads:
            done += 1
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
                if now - before >= DROP_NS:
                    self.dropped_count += 1
                    self._relief_s = SLOW_RELIEF_S
                    break
                if stalls >= MAX_STALLS:
                    break
        self._sequence = sequence
        return done

    def _queue(self, payloads: Sequence[bytes]) -> None:
        self._waiting.extend(payloads)
        self._waiting_bytes += sum(map(len, payloads))
        while self._waiting_bytes > self._limit_bytes and len(self._waiting) > 1:
            self._waiting_bytes -= len(self._waiting.popleft())
            self.dropped_count += 1
        self._backlog.note_backlog(self._waiting_bytes)
        if self._relief is None:
            self._relief = asyncio.get_running_loop().call_later(self._relief_s, self._go_on)

    def _go_on(self) -> None:
        self._relief = None
        waiting, self._waiting = list(self._waiting), deque()
        self._waiting_bytes = 0
        rest = waiting[self._put(waiting) :]
        if rest:
            self._queue(rest)
        else:
            self._backlog.note_backlog(0)

    def _declare(self) -> None:
        session = self._node.session.zenoh
        if self._qos.is_latching:
            self._matching = None
            self._publisher: _Putting = ext.declare_advanced_publisher(
                session,
                self._key,
                congestion_control=zenoh.CongestionControl.DROP,
                cache=ext.CacheConfig(max_samples=self._qos.depth),
                publisher_detection=True,
            )
        else:
            publisher = session.declare_publisher(
                self._key,
                congestion_control=zenoh.CongestionControl.DROP,
                reliability=zenoh.Reliability.RELIABLE,
            )
            self._matching = publisher.declare_matching_listener(
                zenoh.handlers.Callback(self._match, indirect=False)
            )
            # The stubs call it a bool.
            self._is_matched = cast(zenoh.MatchingStatus, publisher.matching_status).matching
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
        """Publish the payloads in order; False asks the caller to await `drained`: a link is full."""
        return self._is_closed or self._publication.publish(payloads)

    async def drained(self, timeout_s: float) -> None:
        """Wait until what waits for a full link is little."""
        await self._publication.drained(timeout_s)

    async def close(self) -> None:
        """Unadvertise, with the last handle. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            self._publication.handle_count -= 1
            if self._publication.handle_count == 0:
                self._on_close(self._publication)
