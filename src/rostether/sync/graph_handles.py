"""The handles of a node for programs without asyncio."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, Generic, ParamSpec, TypeVar, overload

from rostether.graph import ports
from rostether.graph.message_stream import MessageStream
from rostether.graph.typed_handles import CallbackSubscriber, TypedPublisher, TypedServiceClient
from rostether.mechanisms.callback_thread import CallbackThread
from rostether.serde.type_classes import Response
from rostether.serde.values import Message
from rostether.sync.blocking import LOOP, Blocking, blocking, in_loop

P = ParamSpec("P")
M = TypeVar("M", bound=Message)


class Publisher(Blocking[TypedPublisher[...]], Generic[P]):
    """Publishes messages of one type; made by `Graph.publisher`. `P` are the type's fields."""

    _publish = in_loop(TypedPublisher.publish)

    @overload
    def publish(self, message: object, /) -> bool: ...
    @overload
    def publish(self, *args: P.args, **fields: P.kwargs) -> bool: ...
    def publish(self, *args: Any, **fields: Any) -> bool:
        """Publish one message, given as a message, by its fields, or as the value of its only field.

        Returns False if a subscriber is too slow: then call `drained` before you publish more. Raises
        SerializationError with the name of a field that does not fit.
        """
        return self._publish(*args, **fields)

    drained = blocking(TypedPublisher.drained)
    wait_for_subscriber = blocking(TypedPublisher.wait_for_subscriber)
    close = blocking(TypedPublisher.close)

    @property
    def topic(self) -> str:
        """The resolved topic name."""
        return self.wrapped.topic

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        return self.wrapped.subscriber_count


class Subscriber(Blocking[CallbackSubscriber]):
    """Calls a function, in a thread, with each message until it is closed; made by `Graph.subscriber`."""

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


class ServiceServer(Blocking[ports.ServiceServer]):
    """A service that is offered until it is closed; made by `Graph.service_server`."""

    close = blocking(ports.ServiceServer.close)


class ServiceClient(Blocking[TypedServiceClient[Response]]):
    """Calls a service; made by `Graph.service_client`."""

    call = blocking(TypedServiceClient[Response].call)


class ParamWatch(Blocking[ports.Watch]):
    """Calls a function, in a thread, with each new value until it is closed; made by `Graph.watch_param`."""

    close = blocking(ports.Watch.close)


class Messages(Generic[M]):
    """The messages of a topic, to loop over; made by `Graph.messages`.

    The subscription begins with the loop, or the first `next`, and ends with the loop or `close`. Each
    message goes to only one of the threads that loop over the object. If one loop ends, all end.
    """

    def __init__(self, is_closed: Callable[[], bool], stream: MessageStream[M]) -> None:
        self._is_closed = is_closed
        self._stream = stream
        self._waiting: asyncio.Task[M] | None = None
        self._lock = asyncio.Lock()
        self._ended_count = 0

    @property
    def dropped_count(self) -> int:
        """How many messages were dropped because the loop was too slow."""
        return self._stream.dropped_count

    def __iter__(self) -> Iterator[M]:
        try:
            with suppress(StopIteration):
                while True:
                    yield next(self)
        finally:
            self.close()

    def __next__(self) -> M:
        """Wait for the next message and return it."""
        try:
            return LOOP.call(self._next())
        except StopAsyncIteration:
            raise StopIteration from None

    def close(self) -> None:
        """Unsubscribe. Idempotent."""
        if not self._is_closed():
            LOOP.call(self._end())

    async def _next(self) -> M:
        ended_count = self._ended_count
        async with self._lock:
            if self._ended_count != ended_count:
                raise StopAsyncIteration
            self._waiting = asyncio.ensure_future(anext(self._stream))
            try:
                return await self._waiting
            except asyncio.CancelledError:
                task = asyncio.current_task()
                # After Ctrl-C, the caller no longer waits for this error.
                if self._ended_count == ended_count or (task is not None and task.cancelling()):
                    raise
                raise StopAsyncIteration from None

    async def _end(self) -> None:
        self._ended_count += 1
        # A generator cannot be closed while it runs, for instance after Ctrl-C.
        if self._waiting is not None:
            self._waiting.cancel()
            await asyncio.wait([self._waiting])
        await self._stream.aclose()
