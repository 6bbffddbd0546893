"""rospy.Service, ServiceProxy and wait_for_service."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Callable
from typing import Any

from rostether.errors import ConfigError, RostetherError, ServiceCallError, ServiceUnavailableError
from rostether.mechanisms.loop_thread import run_in_thread
from rostether.msgdef.interface import ANY_MD5SUM, ANY_MESSAGE, ANY_TYPE, ServiceType
from rostether.ros1.environment import parse_rpc_uri
from rostether.ros1.node.service_client import ServiceClient
from rostether.ros1.node.service_server import CALLER_FIELDS
from rostether.rospy.client.exceptions import ROSException, ROSInterruptException, ServiceException
from rostether.rospy.client.logs import logerr
from rostether.rospy.client.message import Message, message_bytes, read_message
from rostether.rospy.client.message_types import ServiceClass, service_type_of
from rostether.rospy.client.names import names
from rostether.rospy.client.node import is_initialized, node
from rostether.rospy.client.publisher import args_kwds_to_message
from rostether.rospy.client.shutdown import is_shutdown, shutdown
from rostether.rospy.client.stamps import in_seconds
from rostether.rospy.client.subscriber import DEFAULT_BUFF_SIZE

_served: dict[str, Service] = {}
_ANY_SERVICE = ServiceType(ANY_TYPE, ANY_MD5SUM, ANY_MESSAGE, ANY_MESSAGE)


class Service:
    """Offers a service; `handler` gets a request, and returns a response or its fields.

    `buff_size` has no effect. Raises ValueError for an empty name, ServiceException if the node already
    offers the service.
    """

    def __init__(
        self,
        name: str,
        service_class: type[ServiceClass],
        handler: Callable[[Any], Any],
        buff_size: int = DEFAULT_BUFF_SIZE,
        error_handler: Callable[..., object] | None = None,
    ) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("service name is not a non-empty string")
        self.resolved_name = names.resolve(name) if is_initialized() else names.resolve_early(name)
        self.service_class = service_class
        self.request_class = service_class._request_class
        self.response_class = service_class._response_class
        self.handler = handler
        self.done = False
        self._error_handler = error_handler
        self._server: Any = None
        if self.resolved_name in _served:
            raise ServiceException(f"service [{self.resolved_name}] already registered")
        _served[self.resolved_name] = self
        node.when_joined(self._open)

    def shutdown(self, reason: str = "") -> None:
        """Stop offering the service."""
        self.done = True
        node.forget(self._open)
        if _served.get(self.resolved_name) is self:
            del _served[self.resolved_name]
        if self._server is not None and not is_shutdown():
            node.call(self._server.close())

    def spin(self) -> None:
        """Wait until the service or the node is shut down."""
        while not self.done and not shutdown.event.wait(0.1):
            pass

    def error_handler(self, e: Exception, exc_type: Any, exc_value: Any, tb: Any) -> None:
        """Log the error of a handler; a program may pass another function, or override this one."""
        if self._error_handler is not None:
            self._error_handler(e, exc_type, exc_value, tb)
        else:
            logerr("Error processing request: %s\n%s", e, traceback.format_exception(exc_type, exc_value, tb))

    def _open(self) -> None:
        try:
            self._server = node.call(
                node.graph.advertise_service(
                    self.resolved_name, service_type_of(self.service_class), self._answer
                )
            )
        except RostetherError as error:
            raise ServiceException(f"{error}") from None

    async def _answer(self, request: bytes) -> bytes:
        header = dict(CALLER_FIELDS.get())
        return await run_in_thread(lambda: self._handle(request, header))

    def _handle(self, payload: bytes, header: dict[str, str]) -> bytes:
        try:
            request: Any = read_message(self.request_class, payload)
            request._connection_header = header
            return message_bytes(_response_of(self.handler(request), self.response_class))
        except ServiceException as error:
            raise ServiceCallError(f"service cannot process request: {error}") from None
        except Exception as error:  # noqa: BLE001 - the caller gets the error, the service continues
            self.error_handler(error, *sys.exc_info())
            raise ServiceCallError(f"error processing request: {error}") from None


class ServiceProxy:
    """Calls a service like a function. `persistent` calls share a connection; `headers` has no effect."""

    def __init__(
        self,
        name: str,
        service_class: type[ServiceClass],
        persistent: bool = False,
        headers: dict[str, str] | None = None,
    ) -> None:
        self.resolved_name = names.resolve(name)
        self.service_class = service_class
        self.request_class = service_class._request_class
        self.response_class = service_class._response_class
        self.persistent = persistent
        self._client: ServiceClient | None = None

    def __call__(self, *args: Any, **kwds: Any) -> Any:
        """Call the service with a request or the request's fields, and return the response.

        Raises ServiceException, genpy's SerializationError, ROSInterruptException, TypeError.
        """
        return self.call(*args, **kwds)

    def call(self, *args: Any, **kwds: Any) -> Any:
        """Call the service, like `__call__`."""
        request = args_kwds_to_message(self.request_class, args, kwds)
        if request._type != self.request_class._type:
            raise TypeError(f"request object type [{request._type}] does not match service type")
        payload = message_bytes(request)
        client = self._client or ServiceClient(
            self.resolved_name, service_type_of(self.service_class), node.master(), persistent=self.persistent
        )
        if self.persistent:
            self._client = client
        try:
            answer = node.call(client.call(payload))
        except ROSInterruptException:
            raise ROSInterruptException("node shutdown interrupted service call") from None
        except ServiceUnavailableError:
            raise ServiceException(f"service [{self.resolved_name}] unavailable") from None
        except (RostetherError, ROSException) as error:
            text = str(error).replace(f"service {self.resolved_name} ", f"service [{self.resolved_name}] ", 1)
            raise ServiceException(text) from None
        return read_message(self.response_class, answer)

    def wait_for_service(self, timeout: Any = None) -> None:
        """Wait until a node offers the service, like the function `wait_for_service`."""
        _wait(self.resolved_name, timeout)

    def close(self) -> None:
        """Close the connection of a persistent proxy."""
        client, self._client = self._client, None
        if client is not None and not is_shutdown():
            node.call(client.close())


def wait_for_service(service: str, timeout: Any = None) -> None:
    """Wait until a node offers a service.

    Raises ROSException after `timeout` seconds (or a Duration), ValueError if it is zero,
    ROSInterruptException at a shutdown.
    """
    _wait(names.resolve(service), timeout)


def parse_rosrpc_uri(uri: str) -> tuple[str, int]:
    """Return the host and port of a service's URI. Raises ROSException."""
    try:
        address = parse_rpc_uri(uri, scheme="rosrpc")
    except ConfigError:
        raise ROSException(f"not a valid ROS RPC URI: {uri}") from None
    return address.host, address.port


def _response_of(returned: Any, response_class: type[Message]) -> Message:
    """Return what a handler returned as a response. Raises ServiceException."""
    if isinstance(returned, Message) and returned._type == response_class._type:
        return returned
    if returned is None:
        raise ServiceException("service handler returned None")
    try:
        if isinstance(returned, dict):
            return response_class(**returned)
        if isinstance(returned, list | tuple):
            return response_class(*returned)
        return response_class(returned)
    except (TypeError, AttributeError) as error:
        kind = "wrong number of values" if isinstance(returned, list | tuple) else "invalid value"
        raise ServiceException(f"handler returned {kind}: {error}") from None


def _wait(resolved_name: str, timeout: Any) -> None:
    timeout_s = in_seconds(timeout)
    if timeout_s == 0:
        raise ValueError("timeout must be non-zero")
    deadline_s = None if timeout_s is None else time.monotonic() + timeout_s
    try:
        while not is_shutdown():
            left_s = 1.0 if deadline_s is None else min(1.0, deadline_s - time.monotonic())
            if left_s <= 0:
                raise ROSException(f"timeout exceeded while waiting for service {resolved_name}")
            if _is_available(resolved_name, left_s):
                return
    except ROSInterruptException:
        pass
    raise ROSInterruptException("rospy shutdown")


def _is_available(resolved_name: str, timeout_s: float) -> bool:
    # Any type: the request only checks that the server exists.
    client = ServiceClient(resolved_name, _ANY_SERVICE, node.master())
    try:
        node.call(client.wait_until_available(timeout_s))
    except ServiceUnavailableError:
        return False
    return True
