"""One topic that a node publishes: its zenoh publisher and its token, shared by all handles of the node."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Protocol, cast

import zenoh
from zenoh import ext

from rostether.errors import SerializationError
from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES
from rostether.graph.ports import Level
from rostether.graph.publisher_handle import check_same_type
from rostether.msgdef.interface import MessageType
from rostether.ros2.types.type_support import MessageSupport
from rostether.ros2.zenoh.attachment import ATTACHMENT, GID_BYTES, gid_of
from rostether.ros2.zenoh.configuration import WAIT_BEFORE_DROP_US
from rostether.ros2.zenoh.mismatches import Mismatches, is_of_type
from rostether.ros2.zenoh.put_queue import BatchResult, PutQueue
from rostether.ros2.zenoh.qos import DEFAULT_QOS, LATCHED_QOS, Qos
from rostether.ros2.zenoh.shared_session import LiveToken, NodeEntities
from rostether.ros2.zenoh.tokens import Token, TokenKind

# A put that takes this long has waited for room; other puts take a hundredth of this time.
STALL_NS = 300_000

# The number of slow puts before a thread puts the rest of a batch: the scheduler may cause a single one.
MAX_STALLS = 2

# A put that takes this long has timed out, and zenoh has dropped its message.
DROP_NS = WAIT_BEFORE_DROP_US * 1000


class _Putting(Protocol):
    def put(self, payload: bytes, *, attachment: bytes) -> object: ...

    def undeclare(self) -> object: ...


class ZenohPublication:
    """Converts every batch to CDR and passes it to zenoh, which sends it to all subscribers."""

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        support: MessageSupport,
        *,
        node: NodeEntities,
        latch: bool,
        qos: Qos | None = None,
        queue_bytes: int | None = None,
    ) -> None:
        self.topic = topic
        self.type = message_type
        self.handle_count = 0
        self.gids: set[bytes] = set()
        self._support = support
        self._convert = support.converter.to_cdr
        self._node = node
        self._qos = qos or (LATCHED_QOS if latch else DEFAULT_QOS)
        self._key = node.key(topic, support)
        self._mismatches = Mismatches(topic, support, node.report)
        self._sequence = 0
        self._lost_count = 0
        self._queue = PutQueue(
            self._put,
            self._note,
            node.session.put_threads,
            DEFAULT_QUEUE_BYTES if queue_bytes is None else queue_bytes,
        )
        self._is_refusal_reported = False
        self._is_loss_reported = False
        self._is_closed = False
        self._subscribers: list[Token] = []
        self._declare()
        node.session.graph.listen(TokenKind.SUBSCRIBER, topic, self._update_subscribers)
        self._update_subscribers()

    @property
    def dropped_count(self) -> int:
        """How many messages did not fit their type or were dropped; zenoh reports no other losses."""
        return self._lost_count + self._queue.dropped_count

    @property
    def subscriber_count(self) -> int:
        """How many subscribers of the same type there are; 0 before zenoh has a route to them."""
        return len(self._subscribers) if self._subscribers and self._has_route() else 0

    def share(self, message_type: MessageType, *, latch: bool) -> None:
        """Prepare for another handle, which may latch the topic. Raises TypeMismatchError."""
        check_same_type(self.topic, self.type, message_type)
        if latch and not self._qos.is_latching:
            self._undeclare()
            self._qos = LATCHED_QOS
            self._declare()

    def publish(self, payloads: Sequence[bytes]) -> bool:
        """Put a batch, or queue it while a link is full; see `graph.ports.Publisher.publish_raw`."""
        if self._is_closed or not (self._is_matched or self._subscribers or self._qos.is_latching):
            return True
        queue = self._queue
        if queue.is_idle:
            puts = self._put(payloads, MAX_STALLS)
            self._note(puts)
            if puts.done == len(payloads):
                return queue.flow.is_open
            payloads = payloads[puts.done :]
        queue.add(payloads)
        return queue.flow.is_open

    async def drained(self, timeout_s: float) -> None:
        """Wait until the queue for a full link is short, at most `timeout_s`."""
        await self._queue.flow.drained(timeout_s)

    async def close(self) -> None:
        """Unadvertise, after the queued messages are sent."""
        self._is_closed = True
        try:
            await self._queue.finish()
        finally:
            self._node.session.graph.unlisten(TokenKind.SUBSCRIBER, self.topic, self._update_subscribers)
            self._subscribers = []
            self._undeclare()

    def _put(self, payloads: Sequence[bytes], max_stalls: int | None = None) -> BatchResult:
        """Put messages, until `max_stalls` of them have waited for room (None: all, for a thread)."""
        convert, put, gid, sequence = self._convert, self._publisher.put, self._gid, self._sequence
        pack, clock = ATTACHMENT.pack, time.time_ns
        puts = BatchResult()
        done = stalls = 0
        now = clock()
        for payload in payloads:
            done += 1
            try:
                cdr = convert(payload)
            except SerializationError as error:
                puts.misfits += 1
                puts.error = error
                continue
            sequence += 1
            before = now
            put(cdr, attachment=pack(sequence, now, GID_BYTES, gid))
            now = clock()
            if now - before > STALL_NS:
                puts.longest_ns = max(puts.longest_ns, now - before)
                puts.lost += now - before >= DROP_NS
                stalls += 1
                if stalls == max_stalls or (max_stalls is not None and now - before >= DROP_NS):
                    break
        self._sequence = sequence
        puts.done = done
        return puts

    def _note(self, puts: BatchResult) -> None:
        self._queue.note_longest(puts.longest_ns)
        self._lost_count += puts.lost
        if puts.lost and not self._is_loss_reported:
            self._is_loss_reported = True
            self._node.report(
                Level.WARN,
                f"{self.topic}: a subscriber hangs or is too slow, and messages are lost; find it with ros2"
                " topic info -v (zenoh does not report which subscriber, or how many messages are lost)",
            )
        if puts.error is not None:
            self._refuse(puts.misfits, puts.error)

    def _declare(self) -> None:
        session = self._node.session.zenoh
        # zenoh's matching status includes subscribers without a token.
        self._is_matched = False
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
            self._publisher = publisher
            # The listener is called immediately if there is a subscriber. Reading the status here would be a
            # race: a thread may report a newer status before the read one is stored.
            self._matching = publisher.declare_matching_listener(
                zenoh.handlers.Callback(self._match, indirect=False)
            )
        self._token: LiveToken = self._node.declare(TokenKind.PUBLISHER, self.topic, self._support, self._qos)
        self._gid = gid_of(self._token.text)
        self.gids.add(self._gid)

    def _undeclare(self) -> None:
        self._token.withdraw()
        self._publisher.undeclare()

    def _match(self, status: zenoh.MatchingStatus) -> None:
        # This runs in one of zenoh's threads; a single assignment needs no lock.
        self._is_matched = status.matching

    def _has_route(self) -> bool:
        """Return whether messages reach a subscriber or are stored. A query of zenoh takes 1 µs."""
        if self._is_matched or not isinstance(self._publisher, zenoh.Publisher):
            return True
        # The type stubs declare the status as bool.
        return cast(zenoh.MatchingStatus, self._publisher.matching_status).matching

    def _update_subscribers(self) -> None:
        tokens = self._node.session.graph.endpoints(TokenKind.SUBSCRIBER, self.topic)
        self._subscribers = [token for token in tokens if is_of_type(token, self._support)]
        self._mismatches.report(tokens)

    def _refuse(self, count: int, error: SerializationError) -> None:
        self._lost_count += count
        if not self._is_refusal_reported:
            self._is_refusal_reported = True
            self._node.report(Level.WARN, f"{self.topic}: a message cannot be converted for ROS 2: {error}")
