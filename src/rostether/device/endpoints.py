"""The topics and services that a device declares."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, overload

from rostether.device.endpoint_handles import Messages, Publisher, Subscriber
from rostether.device.line import DeviceLine
from rostether.device.services import Handler, ServiceClient, ServiceServer
from rostether.graph.callbacks import require_callable, require_plain
from rostether.graph.log_methods import LogMethods
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES
from rostether.rosserial.device_link import DeviceLink
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.type_classes import Request, Response, Service, name_of_type
from rostether.serde.values import Message

P = ParamSpec("P")
M = TypeVar("M", bound=Message)


class Endpoints(LogMethods):
    """Declares a device's topics and services on its link, before or after the line opens.

    Every method that takes a type raises DefinitionError if its definition is invalid, and the subclass
    UnknownTypeError if there is none.
    """

    def __init__(self, store: TypeStore, link: DeviceLink, line: DeviceLine) -> None:
        self._store = store
        self._link = link
        self._line = line
        self._receivers: dict[int, Callable[[list[bytes]], None]] = {}
        self._servers: list[ServiceServer] = []
        self._streams: list[Messages[Any]] = []
        self._clients: list[ServiceClient[Any]] = []

    @abstractmethod
    async def wait_connected(self, timeout_s: float | None = None) -> None:
        """Wait until a host is connected. Raises TransportTimeoutError, TransportClosedError."""

    @abstractmethod
    def _no_host_cause(self) -> str:
        """Return the end of an error with the reason why no host is connected; empty if one is."""

    @abstractmethod
    def now(self) -> Time:
        """Return the host's time."""

    def message(self, type_name: str, /, **fields: Any) -> Message:
        """Create a message of any known type. Raises UnknownTypeError, SerializationError."""
        return self._store.codec(type_name).message_class(**fields)

    @overload
    def publisher(self, topic: str, type_name: str) -> Publisher[...]: ...
    @overload
    def publisher(self, topic: str, type_name: Callable[P, Message]) -> Publisher[P]: ...
    def publisher(self, topic: str, type_name: str | Callable[..., Message]) -> Publisher[...]:
        """Declare a topic to send on, of a type given by name or as a class of `rostether.msg`.

        Raises UnknownTypeError, LocalProtocolError.
        """
        name = name_of_type(type_name)
        codec = self._store.codec(name)
        topic_id = self._link.add_publisher(topic, name, self._md5sum(name))
        self._line.flush_soon()
        return Publisher(topic, topic_id, codec, self._line, self.now)

    @overload
    def subscriber(self, topic: str, type_name: str, callback: Callable[[Message], object]) -> Subscriber: ...
    @overload
    def subscriber(self, topic: str, type_name: type[M], callback: Callable[[M], object]) -> Subscriber: ...
    def subscriber(
        self, topic: str, type_name: str | type[Message], callback: Callable[[Any], object]
    ) -> Subscriber:
        """Declare a topic to receive; the callback is a plain function.

        Raises UnknownTypeError, LocalProtocolError, TypeError.
        """
        require_plain("callback", callback, "write a plain function, or loop over device.messages()")
        name = name_of_type(type_name)
        subscriber = Subscriber(topic, self._store.codec(name), callback)
        topic_id = self._link.add_subscriber(topic, name, self._md5sum(name))
        self._receivers[topic_id] = subscriber.receive
        self._line.flush_soon()
        return subscriber

    @overload
    def messages(
        self, topic: str, type_name: str, *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> Messages[Message]: ...
    @overload
    def messages(
        self, topic: str, type_name: type[M], *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> Messages[M]: ...
    def messages(
        self, topic: str, type_name: str | type[Message], *, queue_size: int = DEFAULT_QUEUE_MESSAGES
    ) -> Messages[Any]:
        """Declare a topic to receive, and return its messages. Raises the same errors as `subscriber`.

        `queue_size` limits the waiting messages; above it, the oldest are dropped and counted.
        """
        messages = Messages[Any](topic, queue_size)
        self.subscriber(topic, name_of_type(type_name), messages.put)
        self._streams.append(messages)
        return messages

    @overload
    def service_server(
        self, service: str, type_name: str, handler: Handler[Message, Message]
    ) -> ServiceServer: ...
    @overload
    def service_server(
        self, service: str, type_name: type[Service[Request, Response]], handler: Handler[Request, Response]
    ) -> ServiceServer: ...
    def service_server(
        self, service: str, type_name: str | type[Service[Any, Any]], handler: Handler[Any, Any]
    ) -> ServiceServer:
        """Offer a service of a type given by name or as a class of `rostether.srv`; the handler may be async.

        Raises UnknownTypeError, LocalProtocolError, TypeError.
        """
        require_callable("handler", handler)
        name = name_of_type(type_name)
        kind = self._store.registry.service_type(name)
        ids = self._link.add_service_server(service, name, kind.request.md5sum, kind.response.md5sum)
        server = ServiceServer(
            service, ids, self._store.service_codecs(name), handler, self._line, self.logerror
        )
        self._receivers[ids.request_id] = server.receive
        self._servers.append(server)
        self._line.flush_soon()
        return server

    @overload
    def service_client(self, service: str, type_name: str) -> ServiceClient[Message]: ...
    @overload
    def service_client(
        self, service: str, type_name: type[Service[Request, Response]]
    ) -> ServiceClient[Response]: ...
    def service_client(self, service: str, type_name: str | type[Service[Any, Any]]) -> ServiceClient[Any]:
        """Declare a service to call. Raises UnknownTypeError, LocalProtocolError."""
        name = name_of_type(type_name)
        kind = self._store.registry.service_type(name)
        ids = self._link.add_service_client(service, name, kind.request.md5sum, kind.response.md5sum)
        client = ServiceClient[Any](
            service,
            ids,
            self._store.service_codecs(name),
            self._line,
            self.wait_connected,
            self._no_host_cause,
        )
        self._receivers[ids.response_id] = client.receive
        self._clients.append(client)
        self._line.flush_soon()
        return client

    def _md5sum(self, name: str) -> str:
        return self._store.registry.message_type(name).md5sum
