"""A rosserial device for programs without asyncio."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Generic, ParamSpec, TypeVar, overload

from rostether import device
from rostether.device.endpoint_handles import Messages as DeviceMessages
from rostether.device.endpoint_handles import Publisher as DevicePublisher
from rostether.device.services import Answer
from rostether.device.services import ServiceClient as DeviceServiceClient
from rostether.graph.log_methods import LogMethods
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES
from rostether.mechanisms.callback_thread import CallbackThread
from rostether.serde.type_classes import Request, Response, Service, name_of_type
from rostether.serde.values import Message
from rostether.sync.blocking import LOOP, Blocking, OpenContext, blocking, guarded, in_loop, threaded

P = ParamSpec("P")
M = TypeVar("M", bound=Message)


class Publisher(Blocking[DevicePublisher[...]], Generic[P]):
    """Sends messages of one topic to the host; made by `Device.publisher`. `P` are the type's fields."""

    _publish = in_loop(DevicePublisher.publish)

    @overload
    def publish(self, message: object, /) -> bool: ...
    @overload
    def publish(self, *args: P.args, **fields: P.kwargs) -> bool: ...
    def publish(self, *args: Any, **fields: Any) -> bool:
        """Send one message, given as a message, by its fields, or as the value of its only field.

        Returns False if no host is connected or the line is full. Raises SerializationError with the name of
        a field that does not fit, LocalProtocolError if the message exceeds the buffer.
        """
        return self._publish(*args, **fields)

    publish_many = in_loop(DevicePublisher.publish_many)
    drained = blocking(DevicePublisher.drained)


class ServiceClient(Blocking[DeviceServiceClient[Response]]):
    """Calls a service of ROS through the host; made by `Device.service_client`."""

    call = blocking(DeviceServiceClient[Response].call)


class Messages(Blocking[DeviceMessages[M]]):
    """The messages of a topic, to loop over until the device is closed; made by `Device.messages`."""

    @property
    def dropped_count(self) -> int:
        """How many messages were dropped because the loop was too slow."""
        return self.wrapped.dropped_count

    def __iter__(self) -> Iterator[M]:
        return self

    def __next__(self) -> M:
        """Wait for the next message and return it."""
        try:
            return LOOP.call(self.wrapped.__anext__())
        except StopAsyncIteration:
            raise StopIteration from None


class Device(OpenContext[device.Device], LogMethods):
    """A rosserial device in Python; its line opens immediately, and reopens after a loss.

    The arguments and methods are those of `rostether.Device`. Callbacks and handlers run in threads.
    """

    def __init__(self, link: str, **settings: Any) -> None:
        super().__init__(partial(device.Device, link, **settings))

    get_param = blocking(device.Device.get_param)
    wait_connected = blocking(device.Device.wait_connected)
    message = in_loop(device.Device.message)
    log = in_loop(device.Device.log)
    now = in_loop(device.Device.now)
    _publisher = in_loop(device.Device.publisher)
    _subscriber = in_loop(device.Device.subscriber)
    _messages = in_loop(device.Device.messages)
    _service_server = in_loop(device.Device.service_server)
    _service_client = in_loop(device.Device.service_client)

    @property
    def connected(self) -> bool:
        """Whether a host has requested the topics and still answers."""
        return self.wrapped.connected

    @overload
    def publisher(self, topic: str, type_name: str) -> Publisher[...]: ...
    @overload
    def publisher(self, topic: str, type_name: Callable[P, Message]) -> Publisher[P]: ...
    def publisher(self, topic: str, type_name: str | Callable[..., Message]) -> Publisher[...]:
        """Declare a topic to send on. Raises UnknownTypeError, LocalProtocolError."""
        return Publisher(self._publisher(topic, name_of_type(type_name)))

    @overload
    def subscriber(self, topic: str, type_name: str, callback: Callable[[Message], object]) -> None: ...
    @overload
    def subscriber(self, topic: str, type_name: type[M], callback: Callable[[M], object]) -> None: ...
    def subscriber(
        self, topic: str, type_name: str | type[Message], callback: Callable[[Any], object]
    ) -> None:
        """Declare a topic to receive; the callback runs in its own thread.

        Raises UnknownTypeError, LocalProtocolError, TypeError for an async callback.
        """
        thread = CallbackThread(f"rostether {topic}", guarded(callback), limit=DEFAULT_QUEUE_MESSAGES)
        self._subscriber(topic, name_of_type(type_name), lambda message: thread.put([message]))

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
        """Declare a topic to receive, and return its messages.

        Raises UnknownTypeError, LocalProtocolError.
        """
        return Messages(self._messages(topic, name_of_type(type_name), queue_size=queue_size))

    @overload
    def service_server(
        self, service: str, type_name: str, handler: Callable[[Message], Answer[Message]]
    ) -> None: ...
    @overload
    def service_server(
        self,
        service: str,
        type_name: type[Service[Request, Response]],
        handler: Callable[[Request], Answer[Response]],
    ) -> None: ...
    def service_server(
        self, service: str, type_name: str | type[Service[Any, Any]], handler: Callable[[Any], Answer[Any]]
    ) -> None:
        """Offer a service; the handler runs in a thread.

        Raises UnknownTypeError, LocalProtocolError, TypeError for an async handler.
        """
        self._service_server(service, name_of_type(type_name), threaded(handler))

    @overload
    def service_client(self, service: str, type_name: str) -> ServiceClient[Message]: ...
    @overload
    def service_client(
        self, service: str, type_name: type[Service[Request, Response]]
    ) -> ServiceClient[Response]: ...
    def service_client(self, service: str, type_name: str | type[Service[Any, Any]]) -> ServiceClient[Any]:
        """Declare a service to call. Raises UnknownTypeError, LocalProtocolError."""
        return ServiceClient(self._service_client(service, name_of_type(type_name)))
