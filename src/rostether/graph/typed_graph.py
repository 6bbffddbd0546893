"""A graph with decoded messages: the graph port for programs, any implementation below.

publisher = await graph.publisher("/chatter", "std_msgs/String")
publisher.publish({"data": "hello"})
async for message in graph.messages("/chatter"):     # the type is learned from its publisher
    print(message.data)
answer = await graph.call("/enable", "std_srvs/SetBool", {"data": True})
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import aclosing
from typing import Any, TypeAlias, cast

from rostether.errors import GraphError, RostetherError, ServiceCallError
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES, LearnedTypes, MessageStream
from rostether.graph.ports import Graph, Level, ParamValue, Publisher, ServiceServer, Snapshot, Watch
from rostether.msgdef.search_waiting import definitions_at_hand
from rostether.rostime import Time
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

MessageLike: TypeAlias = Message | Mapping[str, Any]
Handler: TypeAlias = Callable[[Message], MessageLike | Awaitable[MessageLike]]

_SUBSCRIBER_POLL_S = 0.01
# After this time without a publisher, a waiting program gets a log line; publishers are found within a
# second.
SILENCE_WARNING_S = 5.0

_LOG = logging.getLogger(__name__)


class TypedPublisher:
    """Publishes messages of one type; made by `TypedGraph.publisher`."""

    def __init__(self, publisher: Publisher, codec: Codec, now: Callable[[], Time]) -> None:
        self.raw = publisher
        self.codec = codec
        self._now = now

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self.raw.topic

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return self.raw.subscriber_count

    def publish(self, message: MessageLike | object = None, /, **fields: Any) -> bool:
        """Publish one message, given whole, by its fields, or as the value of its only field.

        A time may be "now" or seconds. False asks a flooding caller to await `drained`.
        Raises SerializationError naming the field that does not fit.
        """
        value = fields if message is None else self.codec.fields_of(message)
        return self.raw.publish_raw([self.codec.encode(value, now=self._now)])

    async def drained(self, timeout_s: float) -> None:
        """Wait until no subscriber is above its high-water mark."""
        await self.raw.drained(timeout_s)

    async def wait_for_subscriber(self, timeout_s: float | None = None) -> bool:
        """Wait for a subscriber; returns False if none subscribed in time."""
        try:
            async with asyncio.timeout(timeout_s):
                # The port announces no connections; looking is cheap.
                while not self.raw.subscriber_count:  # noqa: ASYNC110
                    await asyncio.sleep(_SUBSCRIBER_POLL_S)
        except TimeoutError:
            return False
        return True

    async def close(self) -> None:
        """Unadvertise. Idempotent."""
        await self.raw.close()


class CallbackSubscriber:
    """Calls back with the messages of a topic until it is closed; made by `TypedGraph.subscriber`."""

    def __init__(self, stream: MessageStream, callback: Callable[[Message], object]) -> None:
        self.topic = stream.topic
        self._stream = stream
        self._callback = callback
        self._task = asyncio.create_task(self._listen())

    async def _listen(self) -> None:
        try:
            async with aclosing(aiter(self._stream)) as messages:
                async for message in messages:
                    try:
                        self._callback(message)
                    except Exception:  # noqa: BLE001 - it is the user's code
                        # One bad message must not end the subscription.
                        _LOG.exception("the callback for %s failed", self.topic)
        except RostetherError as error:
            _LOG.error("the subscription of %s ended: %s", self.topic, error)

    async def close(self) -> None:
        """Unsubscribe. Idempotent."""
        self._task.cancel()
        await asyncio.wait([self._task])


class TypedGraph:
    """One node's membership of a graph, with messages as values; `raw` is the port below."""

    def __init__(self, graph: Graph, store: TypeStore) -> None:
        self.raw = graph
        self.store = store
        self._learned = LearnedTypes(store)

    @property
    def node_name(self) -> str:
        """The node's fully qualified name."""
        return self.raw.node_name

    def resolve(self, name: str) -> str:
        """Return the fully qualified, remapped form of a name. Raises InvalidNameError."""
        return self.raw.resolve(name)

    async def publisher(self, topic: str, type_name: str, *, latch: bool = False) -> TypedPublisher:
        """Advertise a topic. Raises UnknownTypeError, InvalidNameError, GraphError."""
        await definitions_at_hand(self.store.registry, lambda: self.store.registry.message_type(type_name))
        codec = self.store.codec(type_name)
        message_type = self.store.registry.message_type(type_name)
        return TypedPublisher(await self.raw.advertise(topic, message_type, latch=latch), codec, self.raw.now)

    def messages(
        self, topic: str, type_name: str | None = None, *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> MessageStream:
        """Return a topic's messages to loop over; the subscription lasts as long as the loop.

        Without `type_name` each publisher's own definition is used, even if the type is unknown here.
        `queue_size` bounds the waiting messages; beyond it the oldest are dropped and counted.
        """
        return MessageStream(self.raw, self._learned, topic, type_name, queue_size)

    async def subscriber(
        self, topic: str, type_name: str | None, callback: Callable[[Message], object]
    ) -> CallbackSubscriber:
        """Call back with each message of a topic; without `type_name`, of the type that its publisher has.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        stream = self.messages(topic, type_name)
        if type_name is not None:
            registry = self.store.registry
            await definitions_at_hand(registry, lambda: registry.message_type(type_name))
            registry.message_type(type_name)
        return CallbackSubscriber(stream, callback)

    async def wait_for_message(
        self, topic: str, type_name: str | None = None, *, timeout_s: float | None = None
    ) -> Message:
        """Return the next message of a topic; a topic without publishers is logged. Raises TimeoutError."""
        stream = self.messages(topic, type_name, queue_size=1)
        warning = asyncio.create_task(self._warn_of_silence(topic))
        try:
            async with asyncio.timeout(timeout_s), aclosing(aiter(stream)) as messages:
                async for message in messages:
                    return message
        finally:
            warning.cancel()
        raise GraphError(f"node {self.node_name} has left the graph; join again")

    async def _warn_of_silence(self, topic: str) -> None:
        await asyncio.sleep(SILENCE_WARNING_S)
        with contextlib.suppress(RostetherError):
            name = self.raw.resolve(topic)
            known = (await self.raw.snapshot()).topics.get(name)
            if known is None or not known.publishers:
                _LOG.warning("waiting for a message of %s, which has no publisher", name)

    async def call(
        self,
        service: str,
        type_name: str,
        request: MessageLike | None = None,
        *,
        timeout_s: float | None = None,
    ) -> Message:
        """Call a service and return its response.

        Raises ServiceUnavailableError, ServiceTimeoutError, ServiceCallError, SerializationError.
        """
        await definitions_at_hand(self.store.registry, lambda: self.store.registry.service_type(type_name))
        service_type = self.store.registry.service_type(type_name)
        payload = self.store.codec(service_type.request.name).encode({} if request is None else request)
        answer = await self.raw.call_service(service, service_type, payload, timeout_s=timeout_s)
        return self.store.codec(service_type.response.name).decode(answer)

    async def serve(self, service: str, type_name: str, handler: Handler) -> ServiceServer:
        """Offer a service; `handler` takes the request and returns the response, or awaits it.

        If it raises, the call fails and the caller receives the error.
        """
        await definitions_at_hand(self.store.registry, lambda: self.store.registry.service_type(type_name))
        service_type = self.store.registry.service_type(type_name)
        request_codec = self.store.codec(service_type.request.name)
        response_codec = self.store.codec(service_type.response.name)

        async def handle(payload: bytes) -> bytes:
            request = request_codec.decode(payload)
            try:
                answer = handler(request)
                if isinstance(answer, Awaitable):
                    # A message takes any attribute, so the type checker thinks that it could be awaited.
                    answer = await cast("Awaitable[MessageLike]", answer)
                return response_codec.encode(answer)
            except RostetherError:
                raise
            except Exception as error:
                raise ServiceCallError(f"{type(error).__name__}: {error}") from error

        return await self.raw.advertise_service(service, service_type, handle)

    async def get_param(self, name: str, default: ParamValue = None) -> ParamValue:
        """Return a parameter's value, or `default` where there is none and a default is given.

        Raises UnknownNameError.
        """
        if default is not None and not await self.raw.has_param(name):
            return default
        return await self.raw.get_param(name)

    async def set_param(self, name: str, value: ParamValue) -> None:
        """Set a parameter; a mapping replaces the whole tree below it."""
        await self.raw.set_param(name, value)

    async def delete_param(self, name: str) -> None:
        """Delete a parameter. Raises UnknownNameError."""
        await self.raw.delete_param(name)

    async def has_param(self, name: str) -> bool:
        """Return whether a parameter is set."""
        return await self.raw.has_param(name)

    async def search_param(self, name: str) -> str | None:
        """Find the nearest parameter of that name, upward from the node."""
        return await self.raw.search_param(name)

    async def list_params(self) -> Sequence[str]:
        """Return the full names of all parameters, sorted."""
        return await self.raw.list_params()

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> Watch:
        """Call back with the value now and after every change; None means it is unset."""
        return await self.raw.watch_param(name, on_change)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self.raw.log(level, text)

    def logdebug(self, text: str) -> None:
        """Log at level DEBUG."""
        self.log(Level.DEBUG, text)

    def loginfo(self, text: str) -> None:
        """Log at level INFO."""
        self.log(Level.INFO, text)

    def logwarn(self, text: str) -> None:
        """Log at level WARN."""
        self.log(Level.WARN, text)

    def logerror(self, text: str) -> None:
        """Log at level ERROR."""
        self.log(Level.ERROR, text)

    def logfatal(self, text: str) -> None:
        """Log at level FATAL."""
        self.log(Level.FATAL, text)

    def now(self) -> Time:
        """Return ROS time."""
        return self.raw.now()

    async def snapshot(self) -> Snapshot:
        """Return a snapshot of the whole graph."""
        return await self.raw.snapshot()

    def changes(self) -> AsyncIterator[Snapshot]:
        """Yield a snapshot now and one after each change."""
        return self.raw.changes()

    async def close(self) -> None:
        """Leave the graph. Idempotent."""
        await self.raw.close()
