"""A graph with decoded messages: the graph port for programs, on any implementation.

async for message in graph.messages("/chatter"):     # the type is learned from its publisher
    print(message.data)
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import aclosing
from typing import Any, ParamSpec, TypeAlias, TypeVar, overload

from rostether.errors import GraphError, RostetherError, ServiceCallError
from rostether.graph.callbacks import require_callable, require_plain
from rostether.graph.log_methods import LogMethods
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES, LearnedTypes, MessageStream
from rostether.graph.ports import Graph, Level, ParamValue, ServiceServer, Snapshot, Watch
from rostether.graph.typed_handles import CallbackSubscriber, MessageLike, TypedPublisher, TypedServiceClient
from rostether.msgdef.interface import ServiceType
from rostether.msgdef.search_waiting import wait_for_definitions
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.type_classes import Request, Response, Service, name_of_type
from rostether.serde.values import Message

P = ParamSpec("P")
M = TypeVar("M", bound=Message)

ResponseLike: TypeAlias = Response | Mapping[str, Any] | Awaitable[Response | Mapping[str, Any]]
Handler: TypeAlias = Callable[[Message], ResponseLike[Message]]


class TypedGraph(LogMethods):
    """A node in a ROS graph. Messages are values; `raw` sends and receives them as bytes.

    With `reports_silence`, a loop over a topic without publishers is logged. Methods that take a name raise
    InvalidNameError, those that take a type raise DefinitionError or its subclass UnknownTypeError, and those
    that ask the graph raise GraphError if it cannot be reached or refuses.
    """

    def __init__(self, graph: Graph, store: TypeStore, *, reports_silence: bool = False) -> None:
        self.raw = graph
        self.store = store
        self._reports_silence = reports_silence
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
        name, registry = name_of_type(type_name), self.store.registry
        message_type = await wait_for_definitions(registry, lambda: registry.message_type(name))
        codec = self.store.codec(name)
        return TypedPublisher(await self.raw.advertise(topic, message_type, latch=latch), codec, self.raw)

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
        return self._stream(topic, type_name, queue_size, reports_silence=self._reports_silence)

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
        """Call a function with each message of a topic; without `type_name`, the publisher's type is used.

        The function may be async. Raises UnknownTypeError, InvalidNameError, TypeError. If the graph refuses
        the subscription, this is logged.
        """
        require_callable("callback", callback)
        self.resolve(topic)
        # A node that waits for commands may wait for hours.
        stream = self._stream(topic, type_name, DEFAULT_QUEUE_MESSAGES, reports_silence=False)
        if type_name is not None:
            name, registry = name_of_type(type_name), self.store.registry
            await wait_for_definitions(registry, lambda: registry.message_type(name))
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
        """Return the next message of a topic; a topic without publishers is logged.

        Raises TimeoutError, UnknownTypeError, InvalidNameError, and GraphError if the node leaves the graph.
        """
        stream = self._stream(topic, type_name, 1, reports_silence=True)
        try:
            async with asyncio.timeout(timeout_s), aclosing(aiter(stream)) as messages:
                async for message in messages:
                    return message
        except TimeoutError:
            raise TimeoutError(f"no message on {stream.topic} within {timeout_s or 0:g} s") from None
        raise GraphError(f"node {self.node_name} has left the graph; join again")

    def _stream(
        self, topic: str, given: str | type[Message] | None, limit: int, *, reports_silence: bool
    ) -> MessageStream[Any]:
        name = None if given is None else name_of_type(given)
        return MessageStream(self.raw, self._learned, topic, name, limit, reports_silence=reports_silence)

    @overload
    async def call(
        self,
        service: str,
        type_name: str,
        request: MessageLike | None = None,
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> Message: ...
    @overload
    async def call(
        self,
        service: str,
        type_name: type[Service[Request, Response]],
        request: Request | Mapping[str, Any] | None = None,
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> Response: ...
    async def call(
        self,
        service: str,
        type_name: str | type[Service[Any, Any]],
        request: MessageLike | None = None,
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> Message:
        """Call a service of a type, given by name or as a class of `rostether.srv`; return its response.

        Pass the whole request, or its fields. Raises ServiceUnavailableError, ServiceTimeoutError,
        ServiceCallError, TypeMismatchError, SerializationError.
        """
        client = await self.service_client(service, name_of_type(type_name))
        return await client.call(request, timeout_s=timeout_s, **fields)

    @overload
    async def service_client(self, service: str, type_name: str) -> TypedServiceClient[Message]: ...
    @overload
    async def service_client(
        self, service: str, type_name: type[Service[Request, Response]]
    ) -> TypedServiceClient[Response]: ...
    async def service_client(
        self, service: str, type_name: str | type[Service[Any, Any]]
    ) -> TypedServiceClient[Any]:
        """Return a client for many calls of a service, which need not run yet. Raises UnknownTypeError."""
        service_type = await self._service_type(type_name)
        return TypedServiceClient(
            self.raw, service, service_type, self.store.service_codecs(service_type.name)
        )

    @overload
    async def service_server(self, service: str, type_name: str, handler: Handler) -> ServiceServer: ...
    @overload
    async def service_server(
        self,
        service: str,
        type_name: type[Service[Request, Response]],
        handler: Callable[[Request], ResponseLike[Response]],
    ) -> ServiceServer: ...
    async def service_server(
        self, service: str, type_name: str | type[Service[Any, Any]], handler: Callable[[Any], Any]
    ) -> ServiceServer:
        """Offer a service; `handler` takes the request and returns the response, or awaits it.

        If it raises, the caller receives the error. Raises UnknownTypeError, GraphError, TypeError.
        """
        require_callable("handler", handler)
        service_type = await self._service_type(type_name)
        request_codec, response_codec = self.store.service_codecs(service_type.name)

        async def handle(payload: bytes) -> bytes:
            try:
                answer = handler(request_codec.decode(payload))
                if isinstance(answer, Awaitable):
                    answer = await answer
                return response_codec.encode(answer)
            except RostetherError:
                raise
            except Exception as error:
                raise ServiceCallError(f"{type(error).__name__}: {error}") from error

        return await self.raw.advertise_service(service, service_type, handle)

    async def _service_type(self, given: str | type[Service[Any, Any]]) -> ServiceType:
        name, registry = name_of_type(given), self.store.registry
        return await wait_for_definitions(registry, lambda: registry.service_type(name))

    def message(self, type_name: str, /, **fields: Any) -> Message:
        """Make a message of any known type. Raises UnknownTypeError, SerializationError."""
        return self.store.codec(type_name).message_class(**fields)

    async def get_param(self, name: str, default: ParamValue = None) -> ParamValue:
        """Return a parameter's value, or `default` if there is none and a default is given.

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
        """Return the full name of the nearest parameter of that name, upward from the node, else None."""
        return await self.raw.search_param(name)

    async def list_params(self) -> Sequence[str]:
        """Return the full names of all parameters, sorted."""
        return await self.raw.list_params()

    async def watch_param(self, name: str, on_change: Callable[[ParamValue], None]) -> Watch:
        """Call a plain function with the value now and after every change; None means it is unset."""
        require_plain("callback", on_change, "write a plain function")
        return await self.raw.watch_param(name, on_change)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout under this node's name."""
        self.raw.log(level, text)

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
