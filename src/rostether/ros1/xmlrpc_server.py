"""The XML-RPC server of a ROS graph's master or node: a table of methods behind bounded connections.

A method is any callable of XML-RPC values, plain or async. What it raises becomes an answer: a RostetherError
its text, anything else a fault that names the error, and a line in the log; never a traceback to the peer.
"""

from __future__ import annotations

import asyncio
import errno
import inspect
import logging
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from rostether.errors import ConfigError, GraphError, RemoteProtocolError, RostetherError, SerializationError
from rostether.ros1.admission import EVERYBODY, Admission
from rostether.ros1.environment import LOOPBACK, connect_host, format_uri, is_loopback
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.xmlrpc_connection import ServerConnection
from rostether.transports.sockets import system_bind_errors
from rostether.xmlrpc.document_reader import STEP_BYTES, DocumentReader, load_call
from rostether.xmlrpc.values import FaultError, XmlRpcValue, dump_fault, dump_response

Method: TypeAlias = Callable[..., Any]
Dispatch: TypeAlias = Mapping[str, Method]

# A client that reuses its connection does so within seconds; roscpp drops its own after 30 s.
IDLE_TIMEOUT_S = 90.0
# Who connects has a request; a connection that says nothing only holds a descriptor.
FIRST_BYTE_LIMIT_S = 15.0
# A multicall sets the parameters of one launch file; a larger one would hold up everybody else.
MAX_MULTICALL = 10_000
# A client that reads has its answer within milliseconds; one that does not read is not waited for.
_CLOSE_GRACE_S = 1.0
# How many of the largest requests may be received at once.
_LARGEST_AT_ONCE = 4
# Trying to get one free port on several addresses: a clash is rare, two in a row are no accident.
_BIND_ATTEMPTS = 5
_FAULT = 1

_log = logging.getLogger("rostether.ros1.xmlrpc")


class XmlRpcServer:
    """Serves `dispatch` on `port` (0: a free one) of every address in `hosts`.

    `uri` is the URI to advertise, made of `advertised_host` and the port. Besides the methods given,
    `system.multicall` and `system.listMethods` are there.
    """

    def __init__(
        self,
        dispatch: Dispatch,
        *,
        hosts: Sequence[str] = (LOOPBACK,),
        port: int = 0,
        advertised_host: str = LOOPBACK,
        admission: Admission = EVERYBODY,
        idle_timeout_s: float = IDLE_TIMEOUT_S,
        first_byte_limit_s: float = FIRST_BYTE_LIMIT_S,
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
    ) -> None:
        self._methods: dict[str, Method] = {
            **dispatch,
            "system.multicall": self._multicall,
            "system.listMethods": lambda: sorted(self._methods),
        }
        self._hosts = [connect_host(host) for host in hosts]
        self._advertised_host = advertised_host
        self._idle_timeout_s = idle_timeout_s
        self._admission = admission
        self._first_byte_limit_s = first_byte_limit_s
        self._limits = limits
        self._connections: dict[ServerConnection, None] = {}
        self._servers: list[asyncio.Server] = []
        self._sweep: asyncio.TimerHandle | None = None
        self._emptied: asyncio.Event | None = None
        self.port = port

    @property
    def uri(self) -> str:
        """The URI to register and advertise."""
        return format_uri(self._advertised_host, self.port)

    async def start(self) -> None:
        """Begin to listen. Raises GraphError when the port is taken, ConfigError for a foreign address."""
        for attempt in range(_BIND_ATTEMPTS):
            try:
                await self._bind()
            except OSError as error:
                await self.close()
                if error.errno == errno.EADDRNOTAVAIL:
                    raise ConfigError(
                        f"cannot listen on {', '.join(self._hosts)}: not an address of this machine; "
                        "check ROS_IP, ROS_HOSTNAME and --listen"
                    ) from None
                if self.port or error.errno != errno.EADDRINUSE or attempt == _BIND_ATTEMPTS - 1:
                    raise GraphError(
                        f"cannot listen on port {self.port} of {', '.join(self._hosts)} ({error.strerror}): "
                        "stop who uses it or choose another port"
                    ) from error
            else:
                return

    async def _bind(self) -> None:
        loop = asyncio.get_running_loop()
        port = self.port
        for host in self._hosts:
            async with system_bind_errors(host, port):
                server = await loop.create_server(self._accept, host, port, backlog=128)
            self._servers.append(server)
            port = server.sockets[0].getsockname()[1]
        self.port = port

    async def close(self) -> None:
        """Stop listening and end every connection; answers under way are dropped. Idempotent."""
        if self._sweep is not None:
            self._sweep.cancel()
            self._sweep = None
        servers, self._servers = self._servers, []
        for server in servers:
            server.close()
        for connection in list(self._connections):
            connection.close()
        if self._connections:
            self._emptied = asyncio.Event()
            try:
                async with asyncio.timeout(_CLOSE_GRACE_S):
                    await self._emptied.wait()
            except TimeoutError:
                for connection in list(self._connections):
                    connection.abort()
        for server in servers:
            await server.wait_closed()

    def _accept(self) -> ServerConnection:
        return ServerConnection(
            self._answer,
            self._forget,
            self._has_room,
            self._admit,
            max_body_bytes=self._limits.body_bytes,
        )

    def _admit(self, connection: ServerConnection, transport: asyncio.Transport) -> bool:
        if not self._admission.admits(transport):
            return False
        if len(self._connections) >= self._limits.xmlrpc_connections:
            _idlest(self._connections).abort()
        if not is_loopback(connection.host):
            same = [each for each in self._connections if each.host == connection.host]
            if len(same) >= self._limits.xmlrpc_connections_per_host:
                _idlest(same).abort()
        self._connections[connection] = None
        if self._sweep is None:
            self._sweep_later()
        return True

    def _has_room(self) -> bool:
        held_bytes = sum(connection.body_bytes for connection in self._connections)
        return held_bytes <= _LARGEST_AT_ONCE * self._limits.body_bytes

    def _forget(self, connection: ServerConnection) -> None:
        self._connections.pop(connection, None)
        if self._emptied is not None and not self._connections:
            self._emptied.set()

    def _sweep_later(self) -> None:
        shortest_s = min(self._idle_timeout_s, self._first_byte_limit_s, self._limits.xmlrpc_request_s)
        self._sweep = asyncio.get_running_loop().call_later(shortest_s / 4, self._sweep_idle)

    def _sweep_idle(self) -> None:
        self._sweep = None
        now_s = asyncio.get_running_loop().time()
        for connection in list(self._connections):
            if not connection.is_answering and self._is_overdue(connection, now_s):
                connection.abort()
        if self._connections:
            self._sweep_later()

    def _is_overdue(self, connection: ServerConnection, now_s: float) -> bool:
        if now_s - connection.last_active_s > self._idle_timeout_s:
            return True
        waited_s = now_s - connection.waiting_since_s
        if connection.is_receiving:
            return waited_s > self._limits.xmlrpc_request_s
        return not connection.has_spoken and waited_s > self._first_byte_limit_s

    def _answer(self, document: bytes) -> bytes | Awaitable[bytes]:
        """Return the response document, at once when the method is plain and the document small."""
        if len(document) > STEP_BYTES:
            return self._answer_large(document)
        try:
            method, params = load_call(document)
        except RemoteProtocolError as error:
            return dump_fault(_FAULT, str(error))
        return self._respond(method, params)

    async def _answer_large(self, document: bytes) -> bytes:
        reader = DocumentReader(document)
        try:
            for _ in reader.steps():
                await asyncio.sleep(0)
            method, params = reader.call()
        except RemoteProtocolError as error:
            return dump_fault(_FAULT, str(error))
        answer = self._respond(method, params)
        return answer if isinstance(answer, bytes) else await answer

    def _respond(self, method: str, params: Sequence[XmlRpcValue]) -> bytes | Awaitable[bytes]:
        try:
            value = self._call(method, params)
        except Exception as error:  # noqa: BLE001 - whatever a peer provokes must not stop the server
            return _dump_error(method, error)
        if inspect.isawaitable(value):
            return self._answer_later(method, value)
        return _dump(method, value)

    async def _answer_later(self, method: str, value: Awaitable[object]) -> bytes:
        try:
            return _dump(method, await value)
        except Exception as error:  # noqa: BLE001
            return _dump_error(method, error)

    def _call(self, method: str, params: Sequence[XmlRpcValue]) -> Any:
        function = self._methods.get(method)
        if function is None:
            raise FaultError(_FAULT, f'method "{method:.200}" is not supported')
        return function(*params)

    async def _multicall(self, calls: XmlRpcValue) -> XmlRpcValue:
        if not isinstance(calls, list) or len(calls) > MAX_MULTICALL:
            raise FaultError(_FAULT, f"system.multicall takes an array of at most {MAX_MULTICALL} calls")
        answers: list[XmlRpcValue] = []
        for call in calls:
            try:
                answers.append([await self._call_one(call)])
            except Exception as error:  # noqa: BLE001
                answers.append({"faultCode": _FAULT, "faultString": _explain(str(call)[:80], error)})
        return answers

    async def _call_one(self, call: XmlRpcValue) -> XmlRpcValue:
        method = call.get("methodName") if isinstance(call, dict) else None
        params = call.get("params", []) if isinstance(call, dict) else None
        if not isinstance(method, str) or not isinstance(params, list):
            raise FaultError(_FAULT, "system.multicall takes structs of methodName and params")
        if method == "system.multicall":
            raise FaultError(_FAULT, "system.multicall inside system.multicall is forbidden")
        value = self._call(method, params)
        result: XmlRpcValue = await value if inspect.isawaitable(value) else value
        return result


def _idlest(connections: Iterable[ServerConnection]) -> ServerConnection:
    return min(connections, key=lambda each: (not each.is_idle, each.last_active_s))


def _dump(method: str, value: object) -> bytes:
    try:
        return dump_response(value)
    except SerializationError as error:
        return _dump_error(method, error)


def _dump_error(method: str, error: Exception) -> bytes:
    if isinstance(error, RostetherError) and not isinstance(error, (FaultError, SerializationError)):
        return dump_response([-1, _explain(method, error), 0])
    return dump_fault(_FAULT, _explain(method, error))


def _explain(method: str, error: Exception) -> str:
    if isinstance(error, RostetherError):
        return str(error)
    if isinstance(error, TypeError):
        # Nearly always the wrong number of arguments.
        return f"{method}: bad arguments: {error}"
    _log.error("%s failed: %s: %s", method, type(error).__name__, error)
    return f"{method} failed: {type(error).__name__}: {error}"
