"""A node of a ROS graph for programs without asyncio."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager
from functools import partial, wraps
from typing import Any, ParamSpec, TypeVar, overload

from rostether import joining
from rostether.graph.log_methods import LogMethods
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import MessageLike
from rostether.mechanisms.callback_thread import CallbackThread
from rostether.serde.type_classes import Request, Response, Service
from rostether.serde.values import Message
from rostether.sync.blocking import LOOP, OpenContext, blocking, guarded, in_loop, threaded
from rostether.sync.graph_handles import (
    Messages,
    ParamWatch,
    Publisher,
    ServiceClient,
    ServiceServer,
    Subscriber,
)

P = ParamSpec("P")
M = TypeVar("M", bound=Message)


class Graph(OpenContext[TypedGraph], LogMethods):
    """One node on a graph; made by `join`. Its methods are those of `rostether.join`'s graph."""

    _wait_for_message = blocking(TypedGraph.wait_for_message)
    get_param = blocking(TypedGraph.get_param)
    set_param = blocking(TypedGraph.set_param)
    delete_param = blocking(TypedGraph.delete_param)
    has_param = blocking(TypedGraph.has_param)
    search_param = blocking(TypedGraph.search_param)
    list_params = blocking(TypedGraph.list_params)
    snapshot = blocking(TypedGraph.snapshot)
    log = in_loop(TypedGraph.log)
    message = in_loop(TypedGraph.message)
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
        return Publisher(LOOP.call(self.wrapped.publisher(topic, type_name, latch=latch)))

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
        """Return a topic's messages to loop over; without `type_name`, the type of its publisher is used.

        The loop raises UnknownTypeError, DefinitionError, TypeMismatchError, InvalidNameError, GraphError.
        """
        return Messages(
            lambda: self.is_closed, self.wrapped.messages(topic, type_name, queue_size=queue_size)
        )

    @overload
    def wait_for_message(
        self, topic: str, type_name: str | None = None, *, timeout_s: float | None = None
    ) -> Message: ...
    @overload
    def wait_for_message(self, topic: str, type_name: type[M], *, timeout_s: float | None = None) -> M: ...
    def wait_for_message(
        self, topic: str, type_name: str | type[Message] | None = None, *, timeout_s: float | None = None
    ) -> Any:
        """Return the next message of a topic; a topic without publishers is logged.

        Raises TimeoutError, UnknownTypeError, InvalidNameError, and GraphError if the node leaves the graph.
        """
        return self._wait_for_message(topic, type_name, timeout_s=timeout_s)

    @overload
    def subscriber(
        self, topic: str, type_name: str | None, callback: Callable[[Message], object]
    ) -> Subscriber: ...
    @overload
    def subscriber(self, topic: str, type_name: type[M], callback: Callable[[M], object]) -> Subscriber: ...
    def subscriber(
        self, topic: str, type_name: str | type[Message] | None, callback: Callable[[Any], object]
    ) -> Subscriber:
        """Call a function with each message of a topic, in a thread; the queue is bounded.

        Raises UnknownTypeError, InvalidNameError, TypeError for an async callback. If the graph refuses the
        subscription, this is logged.
        """
        thread = CallbackThread(f"rostether {topic}", guarded(callback), limit=DEFAULT_QUEUE_MESSAGES)
        subscriber = self.wrapped.subscriber(topic, type_name, lambda message: thread.put([message]))
        return Subscriber(LOOP.call(subscriber), thread)

    @overload
    def call(
        self,
        service: str,
        type_name: str,
        request: MessageLike | None = None,
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> Message: ...
    @overload
    def call(
        self,
        service: str,
        type_name: type[Service[Request, Response]],
        request: Request | Mapping[str, Any] | None = None,
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> Response: ...
    def call(
        self,
        service: str,
        type_name: str | type[Service[Any, Any]],
        request: MessageLike | None = None,
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> Message:
        """Call a service and return its response; pass the whole request, or its fields.

        Raises UnknownTypeError, ServiceUnavailableError, ServiceTimeoutError, ServiceCallError,
        TypeMismatchError, InvalidNameError, SerializationError.
        """
        return self.service_client(service, type_name).call(request, timeout_s=timeout_s, **fields)

    @overload
    def service_client(self, service: str, type_name: str) -> ServiceClient[Message]: ...
    @overload
    def service_client(
        self, service: str, type_name: type[Service[Request, Response]]
    ) -> ServiceClient[Response]: ...
    def service_client(self, service: str, type_name: str | type[Service[Any, Any]]) -> ServiceClient[Any]:
        """Return a client for many calls of a service, which need not exist yet. Raises UnknownTypeError."""
        return ServiceClient(LOOP.call(self.wrapped.service_client(service, type_name)))

    @overload
    def service_server(
        self, service: str, type_name: str, handler: Callable[[Message], MessageLike]
    ) -> ServiceServer: ...
    @overload
    def service_server(
        self,
        service: str,
        type_name: type[Service[Request, Response]],
        handler: Callable[[Request], Response | Mapping[str, Any]],
    ) -> ServiceServer: ...
    def service_server(
        self, service: str, type_name: str | type[Service[Any, Any]], handler: Callable[[Any], MessageLike]
    ) -> ServiceServer:
        """Offer a service; `handler` takes the request and returns the response, in a new thread.

        If the handler raises an exception, the call fails and the caller receives the error.
        Raises UnknownTypeError, InvalidNameError, GraphError, TypeError for an async handler.
        """
        handle = threaded(handler)
        return ServiceServer(LOOP.call(self.wrapped.service_server(service, type_name, handle)))

    def watch_param(self, name: str, on_change: Callable[[ParamValue], object]) -> ParamWatch:
        """Call a function, in a thread, with the value now and after each change; None means it is unset.

        Raises InvalidNameError, GraphError, TypeError for an async function.
        """
        thread = CallbackThread(f"rostether {name}", guarded(on_change))
        watch = self.wrapped.watch_param(name, lambda value: thread.put([value]))
        return ParamWatch(LOOP.call(watch))


def _blocking_join(make: Callable[P, AbstractAsyncContextManager[TypedGraph]]) -> Callable[P, Graph]:
    @wraps(make)
    def join(*args: P.args, **kwargs: P.kwargs) -> Graph:
        return Graph(partial(make, *args, **kwargs))

    return join


join = _blocking_join(joining.join)
