"""A node of a ROS graph for programs without asyncio."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import AbstractAsyncContextManager, suppress
from functools import partial, wraps
from typing import Any, Generic, ParamSpec, TypeVar, overload

from rostether import joining
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES, MessageStream
from rostether.graph.ports import ParamValue, ServiceServer, Watch
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import CallbackSubscriber, MessageLike, TypedPublisher, name_of_type
from rostether.mechanisms.callback_thread import CallbackThread
from rostether.mechanisms.loop_thread import run_in_thread
from rostether.serde.values import Message
from rostether.sync.waiting import LOOP, Member, Waiting, guarded, in_loop, waiting

P = ParamSpec("P")
M = TypeVar("M", bound=Message)


class Publisher(Waiting[TypedPublisher[...]], Generic[P]):
    """Publishes messages of one type; made by `Graph.publisher`. `P` are the type's fields."""

    _publish = in_loop(TypedPublisher.publish)

    @overload
    def publish(self, message: object, /) -> bool: ...
    @overload
    def publish(self, *args: P.args, **fields: P.kwargs) -> bool: ...
    def publish(self, *args: Any, **fields: Any) -> bool:
        """Publish one message, given whole, by its fields, or as the value of its only field.

        Raises SerializationError naming the field that does not fit.
        """
        return self._publish(*args, **fields)

    drained = waiting(TypedPublisher.drained)
    wait_for_subscriber = waiting(TypedPublisher.wait_for_subscriber)
    close = waiting(TypedPublisher.close)

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self.wrapped.topic

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return self.wrapped.subscriber_count


class Subscriber(Waiting[CallbackSubscriber]):
    """Calls back in a thread of its own until it is closed; made by `Graph.subscriber`."""

    def __init__(self, wrapped: CallbackSubscriber, thread: CallbackThread[Message]) -> None:
        super().__init__(wrapped)
        self._thread = thread

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self.wrapped.topic

    def close(self) -> None:
        """Unsubscribe. Idempotent."""
        self._thread.close()
        LOOP.call(self.wrapped.close())


class Server(Waiting[ServiceServer]):
    """A service that is offered until it is closed; made by `Graph.serve`."""

    close = waiting(ServiceServer.close)


class ParamWatch(Waiting[Watch]):
    """Calls back in a thread of its own until it is closed; made by `Graph.watch_param`."""

    close = waiting(Watch.close)


class Messages(Generic[M]):
    """The messages of a topic, to loop over; made by `Graph.messages`.

    The subscription begins with the loop, or the first `next`, and ends with the loop or `close`.
    """

    def __init__(self, graph: Graph, stream: MessageStream[M]) -> None:
        self._graph = graph
        self._stream = stream
        self._waiting: asyncio.Task[M] | None = None

    @property
    def dropped_count(self) -> int:
        """How many messages came faster than the loop took them."""
        return self._stream.dropped_count

    def __iter__(self) -> Iterator[M]:
        try:
            with suppress(StopIteration):
                while True:
                    yield next(self)
        finally:
            self.close()

    def __next__(self) -> M:
        """Return the next message; waits for it."""
        try:
            return LOOP.call(self._next())
        except StopAsyncIteration:
            raise StopIteration from None

    def close(self) -> None:
        """Unsubscribe. Idempotent."""
        if not self._graph.is_closed:
            LOOP.call(self._end())

    async def _next(self) -> M:
        self._waiting = asyncio.ensure_future(anext(self._stream))
        return await self._waiting

    async def _end(self) -> None:
        # A generator cannot be closed while it runs, as after Ctrl-C.
        if self._waiting is not None:
            self._waiting.cancel()
            await asyncio.wait([self._waiting])
        await self._stream.aclose()


class Graph(Member[TypedGraph]):
    """One node's membership of a graph; made by `join`. Its methods are those of `rostether.join`'s graph."""

    call = waiting(TypedGraph.call)
    _wait_for_message = waiting(TypedGraph.wait_for_message)
    get_param = waiting(TypedGraph.get_param)
    set_param = waiting(TypedGraph.set_param)
    delete_param = waiting(TypedGraph.delete_param)
    has_param = waiting(TypedGraph.has_param)
    search_param = waiting(TypedGraph.search_param)
    list_params = waiting(TypedGraph.list_params)
    snapshot = waiting(TypedGraph.snapshot)
    log = in_loop(TypedGraph.log)
    logdebug = in_loop(TypedGraph.logdebug)
    loginfo = in_loop(TypedGraph.loginfo)
    logwarn = in_loop(TypedGraph.logwarn)
    logerror = in_loop(TypedGraph.logerror)
    logfatal = in_loop(TypedGraph.logfatal)
    now = in_loop(TypedGraph.now)
    resolve = in_loop(TypedGraph.resolve)

    @property
    def node_name(self) -> str:
        """The node's fully qualified name."""
        return self.wrapped.node_name

    @overload
    def publisher(self, topic: str, type_name: str, *, latch: bool = False) -> Publisher[...]: ...
    @overload
    def publisher(
        self, topic: str, type_name: Callable[P, Message], *, latch: bool = False
    ) -> Publisher[P]: ...
    def publisher(
        self, topic: str, type_name: str | Callable[..., Message], *, latch: bool = False
    ) -> Publisher[...]:
        """Advertise a topic of a type, given by name or as a class of `rostether.msg`.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        return Publisher(LOOP.call(self.wrapped.publisher(topic, name_of_type(type_name), latch=latch)))

    @overload
    def messages(
        self, topic: str, type_name: str | None = None, *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> Messages[Message]: ...
    @overload
    def messages(
        self, topic: str, type_name: type[M], *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> Messages[M]: ...
    def messages(
        self,
        topic: str,
        type_name: str | type[Message] | None = None,
        *,
        queue_size: int = DEFAULT_QUEUE_MESSAGES,
    ) -> Messages[Any]:
        """Return a topic's messages to loop over; without `type_name`, of the type that its publisher has."""
        name = None if type_name is None else name_of_type(type_name)
        return Messages(self, self.wrapped.messages(topic, name, queue_size=queue_size))

    @overload
    def wait_for_message(
        self, topic: str, type_name: str | None = None, *, timeout_s: float | None = None
    ) -> Message: ...
    @overload
    def wait_for_message(self, topic: str, type_name: type[M], *, timeout_s: float | None = None) -> M: ...
    def wait_for_message(
        self, topic: str, type_name: str | type[Message] | None = None, *, timeout_s: float | None = None
    ) -> Any:
        """Return the next message of a topic; a topic without publishers is logged. Raises TimeoutError."""
        name = None if type_name is None else name_of_type(type_name)
        return self._wait_for_message(topic, name, timeout_s=timeout_s)

    @overload
    def subscriber(
        self, topic: str, type_name: str | None, callback: Callable[[Message], object]
    ) -> Subscriber: ...
    @overload
    def subscriber(self, topic: str, type_name: type[M], callback: Callable[[M], object]) -> Subscriber: ...
    def subscriber(
        self, topic: str, type_name: str | type[Message] | None, callback: Callable[[Any], object]
    ) -> Subscriber:
        """Call back with each message of a topic, in a thread of its own; waiting messages are bounded.

        Raises UnknownTypeError, InvalidNameError, GraphError.
        """
        name = None if type_name is None else name_of_type(type_name)
        thread = CallbackThread(f"rostether {topic}", guarded(callback), limit=DEFAULT_QUEUE_MESSAGES)
        subscriber = self.wrapped.subscriber(topic, name, lambda message: thread.put([message]))
        return Subscriber(LOOP.call(subscriber), thread)

    def serve(self, service: str, type_name: str, handler: Callable[[Message], MessageLike]) -> Server:
        """Offer a service; `handler` takes the request and returns the response, in a thread of its own.

        If it raises, the call fails and the caller receives the error.
        """

        async def handle(request: Message) -> MessageLike:
            return await run_in_thread(partial(handler, request))

        return Server(LOOP.call(self.wrapped.serve(service, type_name, handle)))

    def watch_param(self, name: str, on_change: Callable[[ParamValue], object]) -> ParamWatch:
        """Call back with the value now and after every change, in a thread; None means it is unset."""
        thread = CallbackThread(f"rostether {name}", guarded(on_change))
        watch = self.wrapped.watch_param(name, lambda value: thread.put([value]))
        return ParamWatch(LOOP.call(watch))


def _waiting_join(make: Callable[P, AbstractAsyncContextManager[TypedGraph]]) -> Callable[P, Graph]:
    @wraps(make)
    def join(*args: P.args, **kwargs: P.kwargs) -> Graph:
        return Graph(partial(make, *args, **kwargs))

    return join


join = _waiting_join(joining.join)
