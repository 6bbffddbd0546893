"""One subscription of a node: its zenoh subscriber, its token, and the queue between zenoh and the loop."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence

import zenoh
from zenoh import ext

from rostether.errors import SerializationError
from rostether.graph.callbacks import call_safely
from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES
from rostether.graph.ports import Level, OnMessages, SubscribeOptions
from rostether.ros2.early_conversion import Received, convert_if_large, payload_of
from rostether.ros2.endpoint_info import connection_fields
from rostether.ros2.handover import Handover, loss_text
from rostether.ros2.types.type_support import ANY_HASH, MessageSupport
from rostether.ros2.zenoh.attachment import gid_of, parse_attachment
from rostether.ros2.zenoh.described_types import Describe, DescribedTypes
from rostether.ros2.zenoh.mismatches import Mismatches, is_of_type
from rostether.ros2.zenoh.qos import DEFAULT_QOS, Qos
from rostether.ros2.zenoh.shared_session import LiveToken, NodeEntities
from rostether.ros2.zenoh.thread_state import keep_thread_state
from rostether.ros2.zenoh.tokens import Token, TokenKind, data_key

# The number of earlier messages requested from a latched publisher: one, as in ROS 1.
LATCHED_SAMPLES = 1


class ZenohSubscriber:
    """Implements `graph.ports.Subscriber`.

    Without `support`, it accepts every type, which it learns from tokens and samples; with the option
    `one_type`, only the type of the first publisher. `describe` asks nodes for unknown types. `own_gids`
    returns the publishers of this node.
    """

    def __init__(
        self,
        topic: str,
        support: MessageSupport | None,
        on_messages: OnMessages,
        options: SubscribeOptions,
        *,
        node: NodeEntities,
        describe: Describe,
        own_gids: Callable[[], set[bytes]],
        on_close: Callable[[ZenohSubscriber], None],
    ) -> None:
        self.topic = topic
        self._support = support
        self._on_messages = on_messages
        self._on_connection = options.get("on_connection")
        self._on_close = on_close
        self._node = node
        # None: messages of this node are not omitted.
        self._own_gids = own_gids if options.get("skip_own") else None
        self._skip_nodes: Container[str] = options.get("skip_nodes", ())
        self._accepts_one_type = options.get("one_type", False)
        # The type of the first publisher, if a subscription of any type accepts only one type.
        self._learned_type: MessageSupport | None = None
        # The sender of a sample is looked up only if some nodes are excluded.
        self._node_names: dict[bytes, str] = {}
        self._what = f"on_messages of {topic}"
        self._is_closed = False
        self._is_misfit_reported = False
        self._is_loss_reported = False
        self._publishers: set[Token] = set()
        self._is_paused = False
        self._tokens: dict[str, LiveToken] = {}
        if support is None:
            self._mismatches = None
            key = data_key(node.session.domain_id, topic, "*", "*")
        else:
            self._mismatches = Mismatches(topic, support, node.report)
            key = node.key(topic, support)
        self._queue: Handover[tuple[str, bytes, Received]] = Handover(
            self._handle_samples, limit=DEFAULT_QUEUE_BYTES
        )
        self._types = DescribedTypes(
            topic,
            node.session.types,
            describe=describe,
            report=node.report,
            on_waiting=self._queue.pause,
            on_found=self._learn,
        )
        # Publishers that are not latched keep no history, so requesting it costs nothing.
        self._subscriber = ext.declare_advanced_subscriber(
            node.session.zenoh,
            key,
            zenoh.handlers.Callback(
                self._put if support is not None and self._accepts_all else self._put_of_any, indirect=False
            ),
            history=ext.HistoryConfig(detect_late_publishers=True, max_samples=LATCHED_SAMPLES),
        )
        if support is not None:
            self._declare_token(support)
        node.session.graph.listen(TokenKind.PUBLISHER, topic, self._update_publishers)
        self._update_publishers()

    @property
    def publisher_count(self) -> int:
        """The number of publishers of the same type."""
        return len(self._publishers)

    def pause(self) -> None:
        """Keep messages in the queue, which drops the oldest if it is full."""
        self._is_paused = True
        self._queue.pause()

    def resume(self) -> None:
        """Pass messages on again."""
        self._is_paused = False
        if not self._types.is_waiting:
            self._queue.resume()

    async def close(self) -> None:
        """Unsubscribe. Idempotent; no callback runs after it returns."""
        if self._is_closed:
            return
        self._is_closed = True
        self._types.close()
        self._queue.close()
        self._node.session.graph.unlisten(TokenKind.PUBLISHER, self.topic, self._update_publishers)
        self._publishers = set()
        for token in self._tokens.values():
            token.withdraw()
        self._subscriber.undeclare()
        self._on_close(self)

    def _put(self, sample: zenoh.Sample) -> None:
        # Called in a zenoh thread, or in this one during a publication.
        keep_thread_state()
        assert self._support is not None
        data = sample.payload.to_bytes()
        received = convert_if_large(self._support.converter.from_cdr, data)
        self._queue.put(("", b"", received), len(data))

    def _put_of_any(self, sample: zenoh.Sample) -> None:
        keep_thread_state()
        gid = b""
        if not self._accepts_all and sample.attachment is not None:
            attachment = parse_attachment(sample.attachment.to_bytes())
            if attachment is not None:
                gid = attachment.gid
                if self._own_gids is not None and gid in self._own_gids():
                    return
        data = sample.payload.to_bytes()
        key, support = "", self._support
        if support is None:
            key = str(sample.key_expr)
            _, type_name, type_hash = key.rsplit("/", 2)
            support = self._types.get(type_name, type_hash)
        received = data if support is None else convert_if_large(support.converter.from_cdr, data)
        self._queue.put((key, gid, received), len(data))

    def _handle_samples(self, samples: Sequence[tuple[str, bytes, Received]]) -> None:
        payloads: list[bytes] = []
        support = self._support
        for key, gid, received in samples:
            # The event loop has already processed the tokens that came before the sample.
            if gid in self._node_names and self._node_names[gid] in self._skip_nodes:
                continue
            if key:
                support = self._of_key(key)
            if support is None:
                continue
            try:
                payloads.append(payload_of(support.converter.from_cdr, received))
            except SerializationError as error:
                self._refuse(error)
        if payloads and not self._is_closed:
            call_safely(self._what, self._on_messages, payloads)
        if self._queue.dropped_count and not self._is_loss_reported:
            self._is_loss_reported = True
            self._node.report(Level.WARN, loss_text(self.topic))

    @property
    def _accepts_all(self) -> bool:
        return self._own_gids is None and self._skip_nodes == ()

    def _update_publishers(self) -> None:
        tokens = self._node.session.graph.endpoints(TokenKind.PUBLISHER, self.topic)
        if self._skip_nodes != ():
            self._node_names = {gid_of(token.format()): token.node_name for token in tokens}
        if self._mismatches is not None:
            self._mismatches.report(tokens)
        if not any(self._is_of_learned_type(token) for token in tokens):
            self._learned_type = None
        known, self._publishers = self._publishers, set()
        for token in sorted(tokens, key=lambda token: token.format()):
            support = self._of_token(token)
            if support is None:
                continue
            self._publishers.add(token)
            if token not in known:
                self._connect(support, token.node_name, token.qos)

    def _connect(self, support: MessageSupport, node_name: str, qos: Qos) -> None:
        if self._support is None:
            self._declare_token(support)
        if self._accepts_one_type and node_name not in self._skip_nodes:
            self._learned_type = support
        if self._on_connection is not None and not self._is_closed:
            fields = connection_fields(
                self.topic,
                support.ros1_type,
                node_name,
                is_latching=qos.is_latching,
                reliability=qos.reliability.name,
            )
            call_safely(f"on_connection of {self.topic}", self._on_connection, fields)

    def _of_token(self, token: Token) -> MessageSupport | None:
        if self._support is None:
            return self._only_learned(self._types.find(token.type, token.type_hash, token.node_name))
        return self._support if is_of_type(token, self._support) else None

    def _is_of_learned_type(self, token: Token) -> bool:
        support = self._learned_type
        return (
            support is not None
            and self._types.find(token.type, token.type_hash, token.node_name) is support
            and token.node_name not in self._skip_nodes
        )

    def _only_learned(self, support: MessageSupport | None) -> MessageSupport | None:
        return support if self._learned_type in (None, support) else None

    def _of_key(self, key: str) -> MessageSupport | None:
        _, type_name, type_hash = key.rsplit("/", 2)
        is_new = not self._types.has(type_name, type_hash)
        support = self._only_learned(self._types.find(type_name, type_hash))
        if is_new and support is not None:
            # The publisher has no token.
            self._connect(support, "", DEFAULT_QOS)
        return support

    def _learn(self) -> None:
        """Continue with the types that a node has described."""
        self._update_publishers()
        if not self._is_paused and not self._types.is_waiting:
            self._queue.resume()

    def _declare_token(self, support: MessageSupport) -> None:
        if support.name not in self._tokens and support.type_hash != ANY_HASH:
            self._tokens[support.name] = self._node.declare(TokenKind.SUBSCRIBER, self.topic, support)

    def _refuse(self, error: SerializationError) -> None:
        if not self._is_misfit_reported:
            self._is_misfit_reported = True
            self._node.report(Level.WARN, f"{self.topic}: a message does not fit its type: {error}")
