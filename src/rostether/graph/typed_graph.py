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
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import aclosing
from typing import Any, ParamSpec, TypeAlias, TypeVar, cast, overload

from rostether.errors import GraphError, RostetherError, ServiceCallError
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES, LearnedTypes, MessageStream
from rostether.graph.ports import Graph, Level, ParamValue, ServiceServer, Snapshot, Watch
from rostether.graph.typed_handles import CallbackSubscriber, MessageLike, TypedPublisher, name_of_type
from rostether.msgdef.search_waiting import definitions_at_hand
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message

P = ParamSpec("P")
M = TypeVar("M", bound=Message)

Handler: TypeAlias = Callable[[Message], MessageLike | Awaitable[MessageLike]]

# After this time without a publisher, a waiting program gets a log line; publishers are found within a
# second.
SILENCE_WARNING_S = 5.0

_LOG = logging.getLogger(__name__)


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

    @overload
    async def publisher(self, topic: str, type_name: str, *, latch: bool = False) -> TypedPublisher[...]: ...
    @overload
    async def publisher(
        self, topic: str, type_name: Callable[P, Message], *, latch: bool = False
    ) -> TypedPublisher[P]: ...
    async def publisher(
        self, topic: str, type_name: str | Callable[..., Message], *, latch: bool = False
    ) -> TypedPublisher[...]:
        """Advertise a topic of a type, given by name or as a class of `rostether.msg`.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        type_name = name_of_type(type_name)
        await definitions_at_hand(self.store.registry, lambda: self.store.registry.message_type(type_name))
        codec = self.store.codec(type_name)
        message_type = self.store.registry.message_type(type_name)
        return TypedPublisher(await self.raw.advertise(topic, message_type, latch=latch), codec, self.raw.now)

    @overload
    def messages(
        self, topic: str, type_name: str | None = None, *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> MessageStream[Message]: ...
    @overload
    def messages(
        self, topic: str, type_name: type[M], *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> MessageStream[M]: ...
    def messages(
        self,
        topic: str,
        type_name: str | type[Message] | None = None,
        *,
        queue_size: int = DEFAULT_QUEUE_MESSAGES,
    ) -> MessageStream[Any]:
        """Return a topic's messages to loop over; the subscription lasts as long as the loop.

        Without `type_name` each publisher's own definition is used, even if the type is unknown here.
        `queue_size` bounds the waiting messages; beyond it the oldest are dropped and counted.
        """
        name = None if type_name is None else name_of_type(type_name)
        return MessageStream(self.raw, self._learned, topic, name, queue_size)

    @overload
    async def subscriber(
        self, topic: str, type_name: str | None, callback: Callable[[Message], object]
    ) -> CallbackSubscriber: ...
    @overload
    async def subscriber(
        self, topic: str, type_name: type[M], callback: Callable[[M], object]
    ) -> CallbackSubscriber: ...
    async def subscriber(
        self, topic: str, type_name: str | type[Message] | None, callback: Callable[[Any], object]
    ) -> CallbackSubscriber:
        """Call back with each message of a topic; without `type_name`, of the type that its publisher has.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        name = None if type_name is None else name_of_type(type_name)
        stream = self.messages(topic, name)
        if name is not None:
            registry = self.store.registry
            await definitions_at_hand(registry, lambda: registry.message_type(name))
            registry.message_type(name)
        return CallbackSubscriber(stream, callback)

    @overload
    async def wait_for_message(
        self, topic: str, type_name: str | None = None, *, timeout_s: float | None = None
    ) -> Message: ...
    @overload
    async def wait_for_message(
        self, topic: str, type_name: type[M], *, timeout_s: float | None = None
    ) -> M: ...
    async def wait_for_message(
        self, topic: str, type_name: str | type[Message] | None = None, *, timeout_s: float | None = None
    ) -> Any:
        """Return the next message of a topic; a topic without publishers is logged. Raises TimeoutError."""
        name = None if type_name is None else name_of_type(type_name)
        stream = self.messages(topic, name, queue_size=1)
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
