"""rospy.Subscriber: calls back in a thread for each publisher; the callbacks of a topic share connections."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rostether.mechanisms.callback_thread import CallbackThread
from rostether.ros1.node.subscription import Subscription
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.logs import logerr
from rostether.rospy.client.message import DeserializationError, Message, read_message
from rostether.rospy.client.message_types import message_type_of
from rostether.rospy.client.node import node
from rostether.rospy.client.shutdown import is_shutdown
from rostether.rospy.client.topic import SharedTopic, Topic, topics

# As in rospy; our buffers have their own sizes.
DEFAULT_BUFF_SIZE = 65536


class SubscribedTopic(SharedTopic[Subscription]):
    """The state that all Subscribers of one topic and class share."""

    verb = "subscribe to"

    def __init__(self, name: str, data_class: type[Message]) -> None:
        super().__init__(name, data_class)
        self.callbacks: list[tuple[Callable[..., object], Any]] = []
        self.queue_size: int | None = None
        self.tcp_nodelay = False
        self._latched: dict[str, Message] = {}
        self._threads: list[CallbackThread[tuple[bytes, Mapping[str, str]]]] = []
        self._full = 0
        self._is_reported = False

    def close(self) -> None:
        """Unsubscribe, and end the threads."""
        for thread in self._threads:
            thread.close()
        self.callbacks = []
        super().close()

    def add_callback(self, callback: Callable[..., object], arguments: Any) -> None:
        """Call back with each later message, and now with the latched messages that were received before."""
        self.callbacks = [*self.callbacks, (callback, arguments)]
        for message in list(self._latched.values()):
            _invoke(message, callback, arguments)

    def remove_callback(self, callback: Callable[..., object], arguments: Any) -> None:
        """Remove a callback. Raises KeyError if there is none with these arguments."""
        remaining = list(self.callbacks)
        try:
            remaining.remove((callback, arguments))
        except ValueError:
            raise KeyError("no matching cb") from None
        self.callbacks = remaining

    async def _make_endpoint(self) -> Subscription:
        return await node.graph.subscribe(
            self.resolved_name,
            message_type_of(self.data_class),
            _ignore,
            on_connection=self._handle_connection,
            tcp_nodelay=self.tcp_nodelay,
        )

    async def _close_endpoint(self, endpoint: Subscription) -> None:
        await endpoint.close()

    def _count_connections(self, endpoint: Subscription) -> int:
        return endpoint.publisher_count

    def _connected_nodes(self, endpoint: Subscription) -> list[str | None]:
        return [connection.node_name for connection in endpoint.connections]

    def _handle_connection(self, fields: Mapping[str, str]) -> Callable[[Sequence[bytes]], None]:
        header = dict(fields)
        thread = CallbackThread(
            f"rospy {self.resolved_name}", self._receive, limit=self.queue_size, on_full=self._note_full
        )
        self._threads = [*(each for each in self._threads if each.is_alive), thread]

        def queue_payloads(payloads: Sequence[bytes]) -> None:
            thread.limit = self.queue_size
            thread.put((payload, header) for payload in payloads)

        return queue_payloads

    def _note_full(self, is_full: bool) -> None:
        node.loop.post(self._pause_or_resume, 1 if is_full else -1)

    def _pause_or_resume(self, change: int) -> None:
        self._full += change
        if self._endpoint is not None and not self._is_closed:
            if self._full:
                self._endpoint.pause()
            else:
                self._endpoint.resume()

    def _receive(self, item: tuple[bytes, Mapping[str, str]]) -> None:
        payload, header = item
        try:
            message: Any = read_message(self.data_class, payload)
        except DeserializationError as error:
            if not self._is_reported:
                self._is_reported = True
                logerr("cannot deserialize a message of %s: %s", self.resolved_name, error)
            return
        message._connection_header = header
        if header.get("latching") == "1":
            self._latched[header.get("callerid", "")] = message
        for callback, arguments in self.callbacks:
            _invoke(message, callback, arguments)


class Subscriber(Topic[SubscribedTopic]):
    """Calls a function with each message of a topic; `buff_size` has no effect.

    Raises ROSException for a size that is not valid.
    """

    def __init__(
        self,
        name: str,
        data_class: type[Message],
        callback: Callable[..., object] | None = None,
        callback_args: Any = None,
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
        tcp_nodelay: bool = False,
    ) -> None:
        super().__init__(name, data_class)
        if queue_size == 0:
            raise ROSException("queue size may not be set to zero")
        if queue_size is not None and type(queue_size) is not int:
            raise ROSException("queue size must be an integer")
        if type(buff_size) is not int or buff_size <= 0:
            raise ROSException("buffer size must be a positive integer")
        self.callback = callback
        self.callback_args = callback_args
        self._key = (SubscribedTopic, self.name, data_class)
        self.impl, is_new = topics.acquire(self._key, lambda: SubscribedTopic(self.name, data_class))
        if queue_size is not None:
            self.impl.queue_size = None if queue_size == -1 else queue_size
        self.impl.tcp_nodelay = self.impl.tcp_nodelay or tcp_nodelay
        if callback is not None:
            self.impl.add_callback(callback, callback_args)
        if is_new:
            node.when_joined(self.impl.open)

    def unregister(self) -> None:
        """End the subscription. Idempotent."""
        if self.impl is not None and self.callback is not None:
            self.impl.remove_callback(self.callback, self.callback_args)
        super().unregister()


def _invoke(message: Message, callback: Callable[..., object], arguments: Any) -> None:
    try:
        if arguments is None:
            callback(message)
        else:
            callback(message, arguments)
    except Exception:  # noqa: BLE001 - an error in a callback must not end the subscription
        if not is_shutdown():
            logerr("bad callback: %s\n%s", callback, traceback.format_exc())


def _ignore(_: Sequence[bytes]) -> None:
    """Do nothing: without a connection there are no messages."""
