"""The XML-RPC server of a ROS graph's master or node: a table of methods behind bounded connections."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Collection, Iterable, Sequence
from time import monotonic

from rostether.errors import ConfigError, GraphError
from rostether.mechanisms.loopback import LOOPBACK, is_loopback
from rostether.mechanisms.tasks import occurs_within
from rostether.ros1.admission import ALLOW_ALL, Admission
from rostether.ros1.environment import format_uri
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.listening import port_of, start_servers
from rostether.ros1.long_work import SLICE_S
from rostether.ros1.xmlrpc_connection import ServerConnection
from rostether.ros1.xmlrpc_methods import Dispatch, MethodTable
from rostether.transports.own_names import OwnNames
from rostether.transports.sockets import close_servers

# A client that reuses its connection does so within seconds; roscpp drops its own after 30 s.
IDLE_TIMEOUT_S = 90.0
# A client connects to send a request; a silent connection only uses a descriptor.
FIRST_BYTE_LIMIT_S = 15.0
# A client that reads has its answer within milliseconds; one that hangs must not delay the end.
_CLOSE_GRACE_S = 1.0
# The maximum share of connections that have not sent a complete request. Above it, they replace each other;
# otherwise, they would replace the connections of nodes that wait between two calls.
_UNUSED_SHARE = 0.25
# How many requests of the largest size may be received at once, and how many such answers may be unread: each
# of the two takes up to 64 MB.
_LARGEST_AT_ONCE = 4


class XmlRpcServer:
    """Serves `dispatch` on `port` (0: a free one) of every address in `hosts`.

    `uri` is the URI to advertise, made of `advertised_host` and the port. Requests to names that are neither
    the machine's nor among `own_names` are refused. The server adds the methods `system.multicall`
    and `system.listMethods`.
    """

    def __init__(
        self,
        dispatch: Dispatch,
        *,
        hosts: Sequence[str] = (LOOPBACK,),
        port: int = 0,
        advertised_host: str = LOOPBACK,
        admission: Admission = ALLOW_ALL,
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
        own_names: Iterable[str] = (),
    ) -> None:
        self._own_names = OwnNames((advertised_host, *hosts, *own_names))
        self._methods = MethodTable(dispatch, limits.body_bytes)
        self._hosts = hosts
        self._advertised_host = advertised_host
        self._admission = admission
        self._limits = limits
        self._turns: deque[ServerConnection] = deque()
        self._connections: dict[ServerConnection, None] = {}
        self._servers: list[asyncio.Server] = []
        self._is_closed = False
        self._sweep: asyncio.TimerHandle | None = None
        self._emptied: asyncio.Event | None = None
        self.port = port

    @property
    def uri(self) -> str:
        """The URI to register and advertise."""
        return format_uri(self._advertised_host, self.port)

    async def start(self) -> None:
        """Begin to listen. Raises the errors of `start_servers`."""
        self._is_closed = False
        try:
            self._servers = await start_servers(self._accept, self._hosts, self.port)
        except (ConfigError, GraphError):
            await self.close()
            raise
        self.port = port_of(self._servers)

    async def close(self) -> None:
        """Stop listening and end every connection; answers in progress are dropped. Idempotent."""
        if self._sweep is not None:
            self._sweep.cancel()
            self._sweep = None
        self._is_closed = True
        servers, self._servers = self._servers, []
        await close_servers(servers)
        for connection in list(self._connections):
            connection.close()
        if self._connections:
            self._emptied = asyncio.Event()
            if not await occurs_within(self._emptied, _CLOSE_GRACE_S):
                for connection in list(self._connections):
                    connection.abort()
        for server in servers:
            await server.wait_closed()

    def _accept(self) -> ServerConnection:
        return ServerConnection(
            self._methods.answer,
            self._forget,
            self._has_room,
            self._make_room,
            self._schedule,
            self._admit,
            max_body_bytes=self._limits.body_bytes,
            is_own_host=self._own_names.include,
        )

    def _admit(self, connection: ServerConnection, transport: asyncio.Transport) -> bool:
        if self._is_closed:
            transport.abort()
            return False
        if not self._admission.admits(transport):
            return False
        if len(self._connections) >= self._limits.xmlrpc_connections:
            _least_useful(self._connections).abort()
        if not is_loopback(connection.host):
            same = [each for each in self._connections if each.host == connection.host]
            if len(same) >= self._limits.xmlrpc_connections_per_host:
                _least_useful(same).abort()
        self._connections[connection] = None
        if self._sweep is None:
            self._sweep_later()
        return True

    def _has_room(self) -> bool:
        held_bytes = sum(connection.body_bytes for connection in self._connections)
        return held_bytes <= _LARGEST_AT_ONCE * self._limits.body_bytes

    def _schedule(self, connection: ServerConnection) -> None:
        self._turns.append(connection)
        if len(self._turns) == 1:
            asyncio.get_running_loop().call_soon(self._serve_waiting)

    def _serve_waiting(self) -> None:
        due_s = monotonic() + SLICE_S
        while self._turns:
            try:
                self._turns[0].resume()
            finally:
                self._turns.popleft()
            if monotonic() >= due_s:
                break
        if self._turns:
            asyncio.get_running_loop().call_soon(self._serve_waiting)

    def _make_room(self) -> None:
        """End the connections whose answers are unread for longest, until the others fit the limit."""
        unsent_bytes = sum(connection.unsent_bytes for connection in self._connections)
        for connection in sorted(self._connections, key=lambda each: each.last_active_s):
            if unsent_bytes <= _LARGEST_AT_ONCE * self._limits.body_bytes:
                return
            if connection.unsent_bytes:
                unsent_bytes -= connection.unsent_bytes
                connection.abort()

    def _forget(self, connection: ServerConnection) -> None:
        self._connections.pop(connection, None)
        if self._emptied is not None and not self._connections:
            self._emptied.set()

    def _sweep_later(self) -> None:
        shortest_s = min(IDLE_TIMEOUT_S, FIRST_BYTE_LIMIT_S, self._limits.xmlrpc_request_s)
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
        if now_s - connection.last_active_s > IDLE_TIMEOUT_S:
            return True
        waited_s = now_s - connection.waiting_since_s
        if connection.is_receiving:
            return waited_s > self._limits.xmlrpc_request_s
        return not connection.has_spoken and waited_s > FIRST_BYTE_LIMIT_S


def _least_useful(connections: Collection[ServerConnection]) -> ServerConnection:
    """Return the connection that makes room: the first without a request, or the longest idle."""
    unused = [each for each in connections if not each.has_spoken]
    if len(unused) > len(connections) * _UNUSED_SHARE:
        return unused[0]
    return min(connections, key=lambda each: (not each.is_idle, each.last_active_s))
