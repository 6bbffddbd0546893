"""The TCPROS server of a node: one port for its topics and its services."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Callable, Sequence

from rostether.errors import ConfigError, GraphError, TypeMismatchError
from rostether.graph.ports import Level
from rostether.ros1.environment import connect_host
from rostether.ros1.tcpros_connection import HandshakeProtocol
from rostether.tcpros.handshake import Purpose, purpose_of

MAX_HANDSHAKES = 256
"""Connections whose header has not come yet: a burst of a whole graph starting, not a flood of strangers."""

_BIND_ATTEMPTS = 5

AcceptPeer = Callable[[dict[str, str], asyncio.Transport], asyncio.Protocol]


class TcprosListener:
    """Takes connections and hands each to `accept_subscriber` or `accept_client` by its header.

    Those raise GraphError to refuse one; a refusal is told to the peer, and a mismatch of types to `report`.
    """

    def __init__(
        self,
        accept_subscriber: AcceptPeer,
        accept_client: AcceptPeer,
        report: Callable[[Level, str], None],
    ) -> None:
        self._accept_subscriber = accept_subscriber
        self._accept_client = accept_client
        self._report = report
        self._servers: list[asyncio.Server] = []
        self._handshakes: dict[HandshakeProtocol, None] = {}
        self.port = 0

    async def start(self, hosts: Sequence[str]) -> None:
        """Listen on a free port, the same on all hosts. Raises ConfigError, GraphError."""
        for attempt in range(_BIND_ATTEMPTS):
            try:
                await self._bind([connect_host(host) for host in hosts])
            except OSError as error:
                await self.close()
                if error.errno == errno.EADDRNOTAVAIL:
                    raise ConfigError(
                        f"cannot listen on {', '.join(hosts)}: not an address of this machine; "
                        "check ROS_IP, ROS_HOSTNAME and --listen"
                    ) from None
                if attempt == _BIND_ATTEMPTS - 1:
                    raise GraphError(f"cannot listen on {', '.join(hosts)}: {error.strerror}") from error
            else:
                return

    async def close(self) -> None:
        """Stop listening and give up handshakes under way. Idempotent."""
        self.port = 0
        servers, self._servers = self._servers, []
        for server in servers:
            server.close()
        for handshake in list(self._handshakes):
            handshake.abort()
        for server in servers:
            await server.wait_closed()

    async def _bind(self, hosts: Sequence[str]) -> None:
        loop = asyncio.get_running_loop()
        for host in hosts:
            server = await loop.create_server(self._take, host, self.port, backlog=128)
            self._servers.append(server)
            self.port = server.sockets[0].getsockname()[1]

    def _take(self) -> HandshakeProtocol:
        if len(self._handshakes) >= MAX_HANDSHAKES:
            next(iter(self._handshakes)).abort()
        handshake = HandshakeProtocol(self._accept)
        self._handshakes[handshake] = None
        handshake.outcome.add_done_callback(lambda outcome: self._done(handshake, outcome))
        return handshake

    def _accept(self, fields: dict[str, str], transport: asyncio.Transport) -> asyncio.Protocol:
        if purpose_of(fields) is Purpose.SUBSCRIBE:
            return self._accept_subscriber(fields, transport)
        return self._accept_client(fields, transport)

    def _done(self, handshake: HandshakeProtocol, outcome: asyncio.Future[asyncio.Protocol]) -> None:
        self._handshakes.pop(handshake, None)
        error = outcome.exception()
        if isinstance(error, TypeMismatchError):
            self._report(Level.WARN, str(error))
