"""The TCPROS server of a node: one port for its topics and its services."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from rostether.errors import GraphError, TypeMismatchError
from rostether.graph.ports import Level
from rostether.mechanisms.loopback import is_loopback
from rostether.ros1.admission import ALLOW_ALL, Admission
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.listening import port_of, start_servers
from rostether.ros1.tcpros_connection import HandshakeProtocol
from rostether.tcpros.handshake import Purpose, purpose_of
from rostether.transports.sockets import close_servers

# Connections whose header has not arrived yet: enough for a whole graph that starts at once.
MAX_HANDSHAKES = 256

# The same for one address that is not this machine, so that it leaves room for others.
MAX_HANDSHAKES_PER_HOST = 64

# The limit of all headers that are being received together: a few of the largest at once.
MAX_HEADERS_BYTES = 8 << 20

AcceptPeer = Callable[[dict[str, str], asyncio.Transport], asyncio.Protocol]


class TcprosListener:
    """Accepts connections and passes each to `accept_subscriber` or `accept_client`, according to its header.

    Both raise GraphError to refuse one. The peer receives the error; `report` receives mismatches of types.
    """

    def __init__(
        self,
        accept_subscriber: AcceptPeer,
        accept_client: AcceptPeer,
        report: Callable[[Level, str], None],
        admission: Admission = ALLOW_ALL,
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
    ) -> None:
        self._accept_subscriber = accept_subscriber
        self._accept_client = accept_client
        self._report = report
        self._admission = admission
        self._limits = limits
        self._servers: list[asyncio.Server] = []
        self._is_closed = False
        self._served: dict[asyncio.Transport, str] = {}
        self._handshakes: dict[HandshakeProtocol, None] = {}
        self.port = 0

    async def start(self, hosts: Sequence[str]) -> None:
        """Listen on a free port, the same on all hosts. Raises ConfigError, GraphError."""
        self._is_closed = False
        self._servers = await start_servers(self._create_handshake, hosts, 0)
        self.port = port_of(self._servers)

    async def close(self) -> None:
        """Stop listening and abort handshakes in progress. Idempotent."""
        self._is_closed = True
        self.port = 0
        servers, self._servers = self._servers, []
        await close_servers(servers)
        for handshake in list(self._handshakes):
            handshake.abort()
        self._served.clear()
        for server in servers:
            await server.wait_closed()

    def _create_handshake(self) -> HandshakeProtocol:
        return HandshakeProtocol(
            self._accept, admit=self._admit, limits=self._limits, has_room=self._has_room
        )

    def _admit(self, handshake: HandshakeProtocol, transport: asyncio.Transport) -> bool:
        if self._is_closed or not self._admission.admits(transport):
            return False
        if len(self._handshakes) >= MAX_HANDSHAKES:
            next(iter(self._handshakes)).abort()
        if not is_loopback(handshake.host):
            same = [each for each in self._handshakes if each.host == handshake.host]
            if len(same) >= MAX_HANDSHAKES_PER_HOST:
                same[0].abort()
        self._handshakes[handshake] = None
        handshake.outcome.add_done_callback(lambda outcome: self._done(handshake, outcome))
        return True

    def _has_room(self) -> bool:
        return sum(each.held_bytes for each in self._handshakes) <= MAX_HEADERS_BYTES

    def _accept(self, fields: dict[str, str], transport: asyncio.Transport) -> asyncio.Protocol:
        self._served = {each: host for each, host in self._served.items() if not each.is_closing()}
        peer = transport.get_extra_info("peername")
        host = peer[0] if peer else ""
        limit, limit_per_host = self._limits.tcpros_connections, self._limits.tcpros_connections_per_host
        if len(self._served) >= limit:
            shown = f"the limit of connections to this node ({limit})"
            raise GraphError(f"{shown} is reached; close other connections")
        if not is_loopback(host) and list(self._served.values()).count(host) >= limit_per_host:
            shown = f"the limit of connections from one address ({limit_per_host})"
            raise GraphError(f"{shown} is reached; close other connections")
        if purpose_of(fields) is Purpose.SUBSCRIBE:
            successor = self._accept_subscriber(fields, transport)
        else:
            successor = self._accept_client(fields, transport)
        self._served[transport] = host
        return successor

    def _done(self, handshake: HandshakeProtocol, outcome: asyncio.Future[asyncio.Protocol]) -> None:
        self._handshakes.pop(handshake, None)
        error = outcome.exception()
        if isinstance(error, TypeMismatchError):
            self._report(Level.WARN, str(error))
