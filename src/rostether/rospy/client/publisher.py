"""rospy.Publisher: publishes from any thread, as fast as the graph accepts messages."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable
from typing import Any

from rostether.mechanisms.callback_thread import CallbackThread
from rostether.ros1.node.publication import Publisher as Ros1Publisher
from rostether.ros1.node.subscriber_connection import SubscriberConnection
from rostether.rospy.client.exceptions import ROSException, ROSSerializationException
from rostether.rospy.client.message import AnyMsg, Message, SerializationError, message_bytes
from rostether.rospy.client.message_types import message_type_of
from rostether.rospy.client.node import is_initialized, node
from rostether.rospy.client.shutdown import is_shutdown
from rostether.rospy.client.topic import SharedTopic, Topic, topics
from rostether.tcpros.message_framing import encode_messages

# The messages and bytes that may wait for the loop's thread: a program that publishes faster has to wait.
MAX_WAITING_MESSAGES = 100
MAX_WAITING_BYTES = 4 << 20

# The limit of that wait: a graph that shuts down accepts no more messages.
MAX_WAIT_S = 1.0

# How long a slow subscriber may delay a call of `publish`.
MAX_PAUSE_S = 0.1


class SubscribeListener:
    """Base class for callbacks about the subscribers of a topic."""

    def peer_subscribe(
        self, topic_name: str, topic_publish: Callable[..., object], peer_publish: Callable[..., object]
    ) -> None:
        """Handle a new subscriber; `peer_publish` publishes only to it."""

    def peer_unsubscribe(self, topic_name: str, num_peers: int) -> None:
        """Handle the end of a subscription; `num_peers` subscribers remain."""


class PublishedTopic(SharedTopic[Ros1Publisher]):
    """The state that all Publishers of one topic share."""

    verb = "publish"

    def __init__(self, name: str, data_class: type[Message]) -> None:
        super().__init__(name, data_class)
        self.is_latch = False
        self.listeners: list[SubscribeListener] = []
        self._sequence = 0
        self._lock = threading.RLock()
        self._waiting: list[bytes] = []
        self._waiting_bytes = 0
        self._is_behind = False
        self._progress = threading.Condition()
        self._listener_thread: CallbackThread[Callable[[], object]] | None = None

    def latch(self) -> None:
        """Keep the last message for later subscribers."""
        self.is_latch = True
        publisher = self._endpoint
        if publisher is not None:
            node.loop.post(publisher.latch)

    def publish(self, message: Message, only: SubscriberConnection | None = None) -> None:
        """Publish to all subscribers, or `only` to one. Raises ROSException for a closed topic."""
        if self._is_closed or self._endpoint is None:
            if not is_shutdown():
                raise ROSException("publish() to a closed topic")
            return
        if not self.connection_count and not self.is_latch:
            return
        node.loop.require_thread()
        with self._lock:
            self._sequence += 1
            if message._has_header:
                message.header.seq = self._sequence
            payload = message_bytes(message)
            if only is not None:
                node.loop.post(only.send, encode_messages([payload]), 1)
            else:
                self._queue(payload)

    def _queue(self, payload: bytes) -> None:
        with self._progress:
            if self._is_busy():
                self._progress.wait_for(lambda: not self._is_busy() or is_shutdown(), MAX_WAIT_S)
            self._waiting.append(payload)
            self._waiting_bytes += len(payload)
            if len(self._waiting) == 1:
                node.loop.post(self._flush)

    def _flush(self) -> None:
        with self._progress:
            payloads, self._waiting = self._waiting, []
            self._waiting_bytes = 0
            publisher = self._endpoint
            keeps_up = publisher is None or publisher.publish_raw(payloads)
            if not keeps_up and not self._is_behind:
                self._is_behind = True
                node.loop.start(self._catch_up())
            self._progress.notify_all()

    def _is_busy(self) -> bool:
        return (
            self._is_behind
            or len(self._waiting) >= MAX_WAITING_MESSAGES
            or self._waiting_bytes >= MAX_WAITING_BYTES
        )

    async def _catch_up(self) -> None:
        if self._endpoint is not None:
            await self._endpoint.drained(MAX_PAUSE_S)
        with self._progress:
            self._is_behind = False
            self._progress.notify_all()

    async def _make_endpoint(self) -> Ros1Publisher:
        publisher = await node.graph.advertise(
            self.resolved_name, message_type_of(self.data_class), latch=self.is_latch
        )
        publisher.watch_subscribers(self._note_subscriber)
        return publisher

    async def _close_endpoint(self, endpoint: Ros1Publisher) -> None:
        self._flush()
        await endpoint.close()

    def _count_connections(self, endpoint: Ros1Publisher) -> int:
        return endpoint.subscriber_count

    def _connected_nodes(self, endpoint: Ros1Publisher) -> list[str | None]:
        return [connection.record.peer for connection in endpoint.connections]

    def _note_subscriber(self, connection: SubscriberConnection, is_connected: bool) -> None:
        if not self.listeners:
            return
        count = self.connection_count

        def notify() -> None:
            for listener in list(self.listeners):
                if is_connected:
                    listener.peer_subscribe(
                        self.resolved_name, self.publish, lambda message: self.publish(message, connection)
                    )
                else:
                    listener.peer_unsubscribe(self.resolved_name, count)

        if self._listener_thread is None:
            self._listener_thread = CallbackThread(f"rospy {self.resolved_name}", _run_contained)
        self._listener_thread.put([notify])


class Publisher(Topic[PublishedTopic]):
    """Publishes messages on a topic; a program may create it before init_node.

    `tcp_nodelay`, `headers` and the value of `queue_size` have no effect.
    """

    def __init__(
        self,
        name: str,
        data_class: type[Message],
        subscriber_listener: SubscribeListener | None = None,
        tcp_nodelay: bool = False,
        latch: bool = False,
        headers: dict[str, str] | None = None,
        queue_size: int | None = None,
    ) -> None:
        super().__init__(name, data_class)
        if queue_size is None:
            warnings.warn(
                "The publisher should be created with an explicit keyword argument 'queue_size'.",
                SyntaxWarning,
                stacklevel=2,
            )
        # A node publishes a topic with one class: the first, as in rospy.
        self._key = (PublishedTopic, self.name)
        self.impl, is_new = topics.acquire(self._key, lambda: PublishedTopic(self.name, data_class))
        if subscriber_listener is not None:
            self.impl.listeners.append(subscriber_listener)
        if latch:
            self.impl.latch()
        if is_new:
            node.when_joined(self.impl.open)

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message, or a new message with these fields.

        Raises ROSSerializationException if a value does not fit its field, ROSException before init_node or
        after `unregister`, and TypeError or AttributeError for arguments that are not fields.
        """
        if self.impl is None:
            raise ROSException("publish() to an unregistered() handle")
        if not is_initialized():
            raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
        message = args_kwds_to_message(self.data_class, args, kwds)
        try:
            self.impl.publish(message)
        except SerializationError as error:
            raise ROSSerializationException(f"{error}") from None


def args_kwds_to_message(data_class: type[Message], args: tuple[Any, ...], kwds: dict[str, Any]) -> Message:
    """Return the message in the arguments of a call, or a new message with these fields.

    Raises TypeError, AttributeError.
    """
    if args and kwds:
        raise TypeError("publish() can be called with arguments or keywords, but not both.")
    if len(args) == 1:
        given = args[0]
        if isinstance(given, Message):
            if given._md5sum == data_class._md5sum or isinstance(given, AnyMsg):
                return given
            wanted = data_class._slot_types[0] if data_class._slot_types else "[]"
            if given._type != wanted:
                raise TypeError(f"expected [{wanted}] but got [{given._type}]")
    return data_class(*args, **kwds)


def _run_contained(function: Callable[[], object]) -> None:
    try:
        function()
    except Exception:  # noqa: BLE001 - an error in a listener ends nothing
        import traceback

        traceback.print_exc()
