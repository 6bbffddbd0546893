"""Topics and services of the in-memory graph: their publishers, subscribers and servers in one process."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Container, Mapping, Sequence

from rostether.errors import RostetherError, ServiceCallError, ServiceUnavailableError, TypeMismatchError
from rostether.graph.callbacks import call_safely, report_error
from rostether.graph.flow_control import DEFAULT_QUEUE_BYTES, PublicationFlow, SubscriberFlow
from rostether.graph.ports import OnMessages, ServiceHandler, SubscribeOptions
from rostether.graph.service_calls import answer_within
from rostether.mechanisms.tasks import start_task
from rostether.msgdef.interface import ANY_MD5SUM, ANY_MESSAGE, ANY_TYPE, MessageType, ServiceType, agree

_log = logging.getLogger("rostether.graph.memory")


class MemoryPublisher:
    """A `Publisher`: messages wait in one queue for each subscriber until the loop delivers them."""

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        node_name: str,
        *,
        latch: bool,
        queue_bytes: int | None,
        on_close: Callable[[MemoryPublisher], None],
    ) -> None:
        self.topic = topic
        self.type = message_type
        self.node_name = node_name
        self.flow = PublicationFlow()
        self.dropped_count = 0
        self.links: list[_Link] = []
        self._queue_bytes = DEFAULT_QUEUE_BYTES if queue_bytes is None else queue_bytes
        self._latch = latch
        self._latched: bytes | None = None
        self._on_close = on_close
        self._is_closed = False

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return len(self.links)

    def publish_raw(self, payloads: Sequence[bytes]) -> bool:
        """Queue the payloads for every subscriber; False means: await `drained` first."""
        if self._is_closed or not payloads:
            return self.flow.is_open
        for link in self.links:
            self.dropped_count += link.put(payloads)
        if self._latch:
            self._latched = payloads[-1]
        return self.flow.is_open

    async def drained(self, timeout_s: float) -> None:
        """Wait until all backlogs are low, at most `timeout_s`. Each call counts as one pause."""
        await self.flow.drained(timeout_s)

    async def close(self) -> None:
        """Unadvertise. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            for link in list(self.links):
                link.close()
            self._on_close(self)

    def connect(self, subscriber: MemorySubscriber) -> None:
        """Connect a subscriber of this type; a mismatch is logged in one line."""
        if subscriber.skip_own and subscriber.node_name == self.node_name:
            return
        if not subscriber.accepts(self):
            _log.warning(
                "%s: %s publishes %s, %s expects %s",
                self.topic,
                self.node_name,
                self.type.name,
                subscriber.node_name,
                subscriber.type.name,
            )
            return
        link = _Link(self, subscriber, self._queue_bytes)
        if self._latched is not None:
            link.put([self._latched])

    def header_fields(self) -> dict[str, str]:
        """Return the header fields of a TCPROS publisher."""
        return {
            "topic": self.topic,
            "type": self.type.name,
            "md5sum": self.type.md5sum,
            "message_definition": self.type.definition,
            "callerid": self.node_name,
            "latching": "1" if self._latch else "0",
        }


class MemorySubscriber:
    """One subscriber of a topic and its queue; implements `Subscriber`."""

    def __init__(
        self,
        topic: str,
        message_type: MessageType,
        node_name: str,
        on_messages: OnMessages,
        *,
        on_close: Callable[[MemorySubscriber], None],
        options: SubscribeOptions,
    ) -> None:
        self.topic = topic
        self.type = message_type
        self.node_name = node_name
        self.skip_own = options.get("skip_own", False)
        self.skip_nodes: Container[str] = options.get("skip_nodes", ())
        self.links: list[_Link] = []
        self._learns_type = options.get("one_type", False) and message_type.name == ANY_TYPE
        self.is_paused = False
        self.is_closed = False
        self._on_messages = on_messages
        self._on_connection = options.get("on_connection")
        self._on_close = on_close

    @property
    def publisher_count(self) -> int:
        """How many publishers are connected now."""
        return len(self.links)

    def accepts(self, publisher: MemoryPublisher) -> bool:
        """Return whether a new publisher's type fits; with `one_type`, the subscriber adopts the first."""
        if self._learns_type and all(link.node_name in self.skip_nodes for link in self.links):
            self.type = ANY_MESSAGE
        if not agree(publisher.type.md5sum, self.type.md5sum):
            return False
        if self._learns_type and publisher.node_name not in self.skip_nodes:
            self.type = publisher.type
        return True

    def pause(self) -> None:
        """Pause until resume; publishers queue."""
        self.is_paused = True

    def resume(self) -> None:
        """Receive the queued messages, and continue."""
        self.is_paused = False
        for link in self.links:
            link.deliver_soon()

    async def close(self) -> None:
        """Unsubscribe. Idempotent; no callback runs after it returns."""
        if not self.is_closed:
            self.is_closed = True
            for link in list(self.links):
                link.close()
            self._on_close(self)

    def deliver_connection(self, fields: Mapping[str, str]) -> None:
        """Report a new publisher's header fields."""
        if self._on_connection is not None:
            call_safely(f"on_connection of {self.topic}", self._on_connection, fields)

    def deliver(self, payloads: Sequence[bytes]) -> None:
        """Deliver a batch; an error of the callback is only logged."""
        call_safely(f"on_messages of {self.topic}", self._on_messages, payloads)


class _Link:
    """One connection: a bounded queue from one publisher to one subscriber."""

    def __init__(self, publisher: MemoryPublisher, subscriber: MemorySubscriber, queue_bytes: int) -> None:
        self._publisher = publisher
        self._subscriber = subscriber
        self._limit_bytes = queue_bytes
        self._queue: deque[bytes] = deque()
        self._bytes = 0
        self._flow = SubscriberFlow(publisher.flow, lambda: self._bytes, queue_bytes)
        self._is_new = True
        self._is_scheduled = False
        publisher.links.append(self)
        subscriber.links.append(self)
        self.deliver_soon()

    @property
    def node_name(self) -> str:
        return self._publisher.node_name

    def put(self, payloads: Sequence[bytes]) -> int:
        """Queue a batch; return how many of the oldest messages were dropped."""
        self._queue.extend(payloads)
        self._bytes += sum(map(len, payloads))
        dropped = 0
        while self._bytes > self._limit_bytes and len(self._queue) > 1:
            self._bytes -= len(self._queue.popleft())
            dropped += 1
        self._flow.update()
        self.deliver_soon()
        return dropped

    def deliver_soon(self) -> None:
        if not self._is_scheduled:
            self._is_scheduled = True
            asyncio.get_running_loop().call_soon(self._deliver)

    def close(self) -> None:
        if self in self._publisher.links:
            self._publisher.links.remove(self)
            self._subscriber.links.remove(self)
        self._flow.end()

    def _deliver(self) -> None:
        self._is_scheduled = False
        if self._subscriber.is_closed:
            return
        if self._is_new:
            self._is_new = False
            self._subscriber.deliver_connection(self._publisher.header_fields())
        if self._queue and not self._subscriber.is_paused:
            payloads = list(self._queue)
            self._queue.clear()
            self._bytes = 0
            self._flow.update()
            if self._publisher.node_name not in self._subscriber.skip_nodes:
                self._subscriber.deliver(payloads)


class MemoryServiceServer:
    """Implements `ServiceServer`; calls run concurrently, and continue after their caller has given up."""

    def __init__(
        self,
        service: str,
        service_type: ServiceType,
        node_name: str,
        handler: ServiceHandler,
        on_close: Callable[[MemoryServiceServer], None],
    ) -> None:
        self.service = service
        self.type = service_type
        self.node_name = node_name
        self._handler = handler
        self._on_close = on_close
        self._calls: set[asyncio.Task[bytes]] = set()
        self._is_closed = False

    async def call(self, service_type: ServiceType, request: bytes, timeout_s: float | None) -> bytes:
        """Run the handler. Raises the errors of `Graph.call_service`."""
        if service_type.md5sum not in (self.type.md5sum, ANY_MD5SUM):
            raise TypeMismatchError(
                f"service {self.service} has type {self.type.name} (md5sum {self.type.md5sum}), "
                f"not {service_type.name} (md5sum {service_type.md5sum}); make both ends use one definition"
            )
        task = start_task(self._calls, self._answer(request))
        # If the caller has given up, an error of the handler is ignored.
        task.add_done_callback(lambda ended: ended.cancelled() or ended.exception())
        async with answer_within(self.service, timeout_s):
            await asyncio.wait((task,))
        if task.cancelled():
            raise ServiceUnavailableError(f"service {self.service} was shut down during the call")
        return task.result()

    async def close(self) -> None:
        """Unadvertise; pending calls fail. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            for task in self._calls:
                task.cancel()
            self._on_close(self)

    async def _answer(self, request: bytes) -> bytes:
        try:
            return await self._handler(request)
        except RostetherError as error:
            raise ServiceCallError(str(error)) from error
        except Exception as error:
            report_error(f"handler of service {self.service}", error)
            raise ServiceCallError(f"error processing request: {error}") from error
