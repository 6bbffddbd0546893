"""A subscription to one topic: its quality of service adapts to the publishers.

    known publishers                 requested QoS
    none                             reliable; for any type: nothing yet, because the type is unknown
    all transient local              transient local, to receive their last messages
    some volatile                    volatile
    some best effort                 best effort

The QoS of a subscription cannot be changed, so a new subscription replaces the old one.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Container, Mapping, Sequence
from functools import partial
from typing import Any

from rostether.errors import RostetherError, SerializationError, TypeMismatchError
from rostether.graph.callbacks import call_safely
from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES
from rostether.graph.ports import Level, OnMessages, SubscribeOptions
from rostether.msgdef.interface import ANY_TYPE, MessageType
from rostether.ros2.early_conversion import Received, convert_if_large, payload_of
from rostether.ros2.handover import Handover, loss_text
from rostether.ros2.rclpy.failures import first_lines
from rostether.ros2.rclpy.installation import interface_class, load_rclpy
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.quality import (
    SUBSCRIBER_DEPTH,
    SubscriberQuality,
    name_policy,
    profile,
    publisher_fields,
    subscriber_quality,
)
from rostether.ros2.rclpy.view import node_name_of
from rostether.ros2.types.type_support import ANY_HASH, MessageSupport

# The messages received before the executor serves the other subscriptions: a few milliseconds of work.
MAX_BATCH = 1000

# The maximum number of different reports of one subscription, so that invalid messages cannot fill the log.
MAX_REPORTS = 16

_GID_BYTES = 16


class RclpySubscriber:
    """Implements `graph.ports.Subscriber`. `open`, `adapt` and `end` run in the executor's thread."""

    def __init__(
        self,
        own: OwnNode,
        topic: str,
        message_type: MessageType,
        on_messages: OnMessages,
        options: SubscribeOptions,
        *,
        on_close: Callable[[RclpySubscriber], Awaitable[None]],
    ) -> None:
        self.topic = topic
        self._own = own
        self._on_messages = on_messages
        self._on_connection = options.get("on_connection")
        self._on_close = on_close
        self._skip_own = options.get("skip_own", False)
        self._skip_nodes: Container[str] = options.get("skip_nodes", ())
        self._is_of_any_type = message_type.name == ANY_TYPE
        self._support: MessageSupport | None = None
        if not self._is_of_any_type:
            self._support = own.types.message(message_type)
        self._quality: SubscriberQuality | None = None
        self._subscription: Any = None
        self._queue: Handover[Received] = Handover(self._deliver, limit=DEFAULT_QUEUE_BYTES)
        # Publishers that were reported as connected, with the names of their nodes.
        self._known: dict[bytes, str] = {}
        self._unnamed: set[bytes] = set()  # Publishers whose node has no name yet.
        # The send time of each publisher's latest message, and the messages that a new subscription may
        # receive again.
        self._latest: dict[bytes, int] = {}
        self._seen: dict[bytes, int] = {}
        self._reported: set[str] = set()
        self._reports_matches = True
        self._is_closed = False

    @property
    def publisher_count(self) -> int:
        """How many publishers are connected now."""
        subscription = self._subscription
        if self._is_closed or subscription is None:
            return 0
        count = getattr(subscription, "get_publisher_count", None)
        return int(self._own.node.count_publishers(self.topic) if count is None else count())

    @property
    def type_name(self) -> str:
        """The type of the topic; empty while it is unknown."""
        return "" if self._support is None else self._support.name

    @property
    def needs_polling(self) -> bool:
        """Whether only polling finds new publishers."""
        return self._subscription is None or not self._reports_matches

    def open(self) -> None:
        """Subscribe. Raises GraphError, InvalidNameError, TypeMismatchError, UnknownTypeError."""
        if self._support is not None:
            interface_class(self._support.name)
        self._adapt()

    def adapt(self) -> None:
        """Adapt to the current publishers."""
        if self._is_closed:
            return
        try:
            self._adapt()
        except RostetherError as error:
            self._report_once(str(error))

    def pause(self) -> None:
        """Keep messages; rclpy cannot make publishers wait, so a full queue drops the oldest."""
        self._queue.pause()

    def resume(self) -> None:
        """Pass messages on again."""
        self._queue.resume()

    async def close(self) -> None:
        """Unsubscribe. Idempotent; no callback runs after it returns."""
        if not self._is_closed:
            self._is_closed = True
            self._queue.close()
            await self._on_close(self)

    def end(self) -> None:
        """Destroy rclpy's subscription."""
        subscription, self._subscription = self._subscription, None
        if subscription is not None:
            self._own.node.destroy_subscription(subscription)

    def _adapt(self) -> None:
        publishers = self._own.node.get_publishers_info_by_topic(self.topic)
        if publishers and self._is_of_any_type:
            types = [each.topic_type for each in publishers]
            if self._support is None or self._support.name not in types:
                self._own.thread.call_in_loop(self._learn_type, types[0])
        if self._support is None:
            return
        of_type = [each for each in publishers if each.topic_type == self._support.name]
        quality = subscriber_quality(of_type)
        if self._subscription is None or (of_type and quality != self._quality):
            self._subscribe(quality)
        self._report_publishers(of_type)

    def _learn_type(self, name: str) -> None:
        # Runs in the event loop, like all compilation of types.
        if self._is_closed or (self._support is not None and self._support.name == name):
            return
        try:
            interface_class(name)
            support = self._own.types.received(name, ANY_HASH)
        except RostetherError as error:
            self._report_once(f"cannot subscribe to {self.topic}: {error}")
        else:
            self._own.thread.submit(partial(self._use_type, support))

    def _use_type(self, support: MessageSupport) -> None:
        # This runs in the executor's thread, so no message of an older type arrives afterwards.
        self.end()
        self._support = support
        self.adapt()

    def _subscribe(self, quality: SubscriberQuality) -> None:
        support = self._support
        assert support is not None
        if self._subscription is not None:
            self._receive_rest(self._subscription, [])
            self._seen = dict(self._latest)
        self.end()

        def on_message(message: bytes, info: Mapping[str, Any]) -> None:
            self._receive_rest(subscription, [(message, info)])

        type_class = interface_class(support.name)
        subscription = self._subscription = self._own.create(
            f"subscribe to {self.topic}",
            support.name,
            lambda: self._own.node.create_subscription(
                type_class,
                self.topic,
                on_message,
                profile(SUBSCRIBER_DEPTH, is_reliable=quality.is_reliable, is_latched=quality.is_latched),
                callback_group=self._own.group,
                event_callbacks=self._event_callbacks(),
                raw=True,
            ),
            lambda: self._own.topic_types(self.topic),
        )
        self._quality = quality
        try:
            self._own.check_definition(self._own.node.get_subscriptions_info_by_topic(self.topic), support)
        except TypeMismatchError:
            self.end()
            raise

    def _event_callbacks(self) -> Any:
        make = load_rclpy().events.SubscriptionEventCallbacks
        try:
            return make(
                matched=lambda _: self.adapt(),
                incompatible_qos=self._handle_mismatch,
                use_default_callbacks=False,
            )
        except TypeError:
            # Humble does not report matched publishers.
            self._reports_matches = False
            return make(incompatible_qos=self._handle_mismatch, use_default_callbacks=False)

    def _handle_mismatch(self, event: Any) -> None:
        self.adapt()
        policy = name_policy(event)
        # `adapt` adapts to these two policies.
        if policy not in ("reliability", "durability"):
            self._report_once(
                f"a publisher of {self.topic} offers a different {policy} than a subscriber of this node "
                "requests; change the publisher's quality of service"
            )

    def _receive_rest(self, subscription: Any, received: list[tuple[bytes, Mapping[str, Any]]]) -> None:
        message_type = subscription.msg_type
        with subscription.handle as handle:
            # In some versions of rclpy, entering the handle's context returns None.
            handle = handle or subscription.handle
            while len(received) < MAX_BATCH:
                message = handle.take_message(message_type, True)
                if message is None:
                    break
                received.append(message)
        messages = [message for message, info in received if self._is_wanted(info)]
        if messages and not self._known and self._on_connection is not None:
            self.adapt()
        assert self._support is not None
        from_cdr = self._support.converter.from_cdr
        for message in messages:
            self._queue.put(convert_if_large(from_cdr, message), len(message))

    def _is_wanted(self, info: Mapping[str, Any]) -> bool:
        gid = (info.get("publisher_gid") or {}).get("data")
        if gid is None:
            return True
        stamp = info["source_timestamp"]
        if self._seen and stamp <= self._seen.get(gid, -1):
            return False
        self._latest[gid] = stamp
        if not self._skip_own and self._skip_nodes == ():
            return True
        if gid not in self._known or gid in self._unnamed:
            self.adapt()
        node_name = self._known.get(gid, "")
        return node_name not in self._skip_nodes and not (self._skip_own and node_name == self._own.name)

    def _report_publishers(self, publishers: Sequence[Any]) -> None:
        assert self._support is not None
        gids = {bytes(each.endpoint_gid[:_GID_BYTES]): each for each in publishers}
        for table in (self._known, self._latest, self._seen):
            for gid in table.keys() - gids.keys():
                del table[gid]
        for gid in (gids.keys() - self._known.keys()) | (self._unnamed & gids.keys()):
            publisher = gids[gid]
            is_new = gid not in self._known
            self._known[gid] = node_name_of(publisher)
            if is_new and self._on_connection is not None:
                fields = publisher_fields(publisher, self.topic, self._support.ros1_type)
                self._own.thread.call_in_loop(self._report_connection, fields)
        self._unnamed = {gid for gid, node_name in self._known.items() if not node_name}

    def _report_connection(self, fields: Mapping[str, str]) -> None:
        if not self._is_closed and self._on_connection is not None:
            call_safely(f"on_connection of {self.topic}", self._on_connection, fields)

    def _deliver(self, messages: Sequence[Received]) -> None:
        if self._is_closed or self._support is None:
            return
        from_cdr = self._support.converter.from_cdr
        payloads = []
        for message in messages:
            try:
                payloads.append(payload_of(from_cdr, message))
            except SerializationError as error:
                self._report_once(f"dropped a message of {self.topic}: {first_lines(str(error))}")
        if payloads:
            call_safely(f"on_messages of {self.topic}", self._on_messages, payloads)
        if self._queue.dropped_count:
            self._report_once(loss_text(self.topic))

    def _report_once(self, text: str) -> None:
        # Reported once: the next check or message would report the same.
        if text not in self._reported and len(self._reported) < MAX_REPORTS:
            self._reported.add(text)
            self._own.report_from_thread(Level.WARN, text)
