"""A rosserial device for programs without asyncio."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rostether import device
from rostether.device.endpoint_handles import Fields
from rostether.device.endpoint_handles import Publisher as DevicePublisher
from rostether.device.services import ServiceClient as DeviceServiceClient
from rostether.graph.message_stream import DEFAULT_QUEUE_MESSAGES
from rostether.mechanisms.callback_thread import CallbackThread
from rostether.mechanisms.loop_thread import run_in_thread
from rostether.serde.values import Message
from rostether.sync.waiting import Member, Waiting, guarded, in_loop, waiting


class Publisher(Waiting[DevicePublisher]):
    """Sends messages of one topic to the host; made by `Device.publisher`."""

    publish = in_loop(DevicePublisher.publish)
    publish_many = in_loop(DevicePublisher.publish_many)


class ServiceClient(Waiting[DeviceServiceClient]):
    """Calls a service of ROS through the host; made by `Device.service_client`."""

    call = waiting(DeviceServiceClient.call)


class Device(Member[device.Device]):
    """A rosserial device in Python; its line opens at once, and again whenever it is lost.

    The arguments and methods are those of `rostether.Device`. Callbacks and handlers run in threads.
    """

    def __init__(self, link: str, **settings: Any) -> None:
        super().__init__(partial(device.Device, link, **settings))

    drained = waiting(device.Device.drained)
    get_param = waiting(device.Device.get_param)
    wait_connected = waiting(device.Device.wait_connected)
    message = in_loop(device.Device.message)
    log = in_loop(device.Device.log)
    logdebug = in_loop(device.Device.logdebug)
    loginfo = in_loop(device.Device.loginfo)
    logwarn = in_loop(device.Device.logwarn)
    logerror = in_loop(device.Device.logerror)
    logfatal = in_loop(device.Device.logfatal)
    now = in_loop(device.Device.now)
    _publisher = in_loop(device.Device.publisher)
    _subscriber = in_loop(device.Device.subscriber)
    _service_server = in_loop(device.Device.service_server)
    _service_client = in_loop(device.Device.service_client)

    @property
    def connected(self) -> bool:
        """Whether a host has asked for the topics and still answers."""
        return self.wrapped.connected

    def publisher(self, topic: str, message_type: str) -> Publisher:
        """Declare a topic to send on. Raises UnknownTypeError, LocalProtocolError."""
        return Publisher(self._publisher(topic, message_type))

    def subscriber(self, topic: str, message_type: str, callback: Callable[[Message], object]) -> None:
        """Declare a topic to receive; the callback runs in a thread of its own.

        Raises UnknownTypeError, LocalProtocolError.
        """
        thread = CallbackThread(f"rostether {topic}", guarded(callback), limit=DEFAULT_QUEUE_MESSAGES)
        self._subscriber(topic, message_type, lambda message: thread.put([message]))

    def service_server(
        self, service: str, service_type: str, handler: Callable[[Message], Fields | None]
    ) -> None:
        """Offer a service; the handler runs in a thread. Raises UnknownTypeError, LocalProtocolError."""

        async def handle(request: Message) -> Fields | None:
            return await run_in_thread(partial(handler, request))

        self._service_server(service, service_type, handle)

    def service_client(self, service: str, service_type: str) -> ServiceClient:
        """Declare a service to call. Raises UnknownTypeError, LocalProtocolError."""
        return ServiceClient(self._service_client(service, service_type))
