"""TCP: a listener for boards, and a client that connects to one peer."""

from __future__ import annotations

import asyncio
import socket
from collections import Counter
from collections.abc import Callable
from time import thread_time
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rostether.errors import RostetherError, TransportOpenError, TransportTimeoutError
from rostether.mechanisms.tasks import start_task
from rostether.mechanisms.text import show_endpoint
from rostether.transports.address import TcpAddress
from rostether.transports.allow_list import AllowList
from rostether.transports.board_keys import NO_KEYS, BoardKeys
from rostether.transports.read_turn import MIN_READ_BYTES, ReadTurn
from rostether.transports.refusals import RefusalLog
from rostether.transports.sockets import (
    READ_BYTES,
    close_servers,
    explain_bind_error,
    explain_connect_error,
    read_buffer,
    start_server,
    tune_stream,
)
from rostether.transports.stream import StreamTransport
from rostether.transports.transport import Transport

# Each connection is a session with its buffers, about 200 KB: a scanner must not exhaust our memory.
MAX_CONNECTIONS = 256
# One host may run a hundred simulated boards, but must leave room for the boards of others.
MAX_CONNECTIONS_PER_HOST = 128
# Connections that have not proven their key yet, of one address and in total; a new one replaces the oldest.
MAX_UNPROVEN_PER_HOST = 16
MAX_UNPROVEN = 128
# Accepted in one turn of the event loop: a burst must not delay the messages of connected boards.
_ACCEPTED_AT_ONCE = 64
# A board on Wi-Fi answers within a second.
CONNECT_LIMIT_S = 5.0
# Only Linux has it; on other systems, acknowledgements are rarely late.
_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)

if TYPE_CHECKING:
    from rostether.transports.greeting import Greeting


class TcpTransport(StreamTransport, asyncio.BufferedProtocol):
    """One TCP connection.

    While its chunks are expensive to process, it reads less at a time: a flood or hostile bytes on one
    connection must not delay the others.
    """

    def __init__(self, peer: str = "") -> None:
        super().__init__(peer, can_pause=True)
        self._buffer = memoryview(b"")
        self._turn = ReadTurn(READ_BYTES)
        self._socket: socket.socket | None = None
        self.host = ""
        self.own_host = ""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep asyncio's transport, and set the socket's options."""
        super().connection_made(transport)
        self._buffer = read_buffer()
        self._socket = sock = transport.get_extra_info("socket")
        tune_stream(sock)
        peer_name = transport.get_extra_info("peername")
        if peer_name:
            self.host = self.remote = peer_name[0]
            self.own_host = transport.get_extra_info("sockname")[0]
            self.peer = f"tcp {show_endpoint(*peer_name[:2])}"

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended.

        If this side sends, the kernel delays acknowledgements for 40 ms, to send them with the next data.
        Some boards, such as an ESP, collect small messages until the last one is acknowledged. After each
        time answer, their next message would have this delay. So this requests an immediate acknowledgement.
        """
        super().write(data)
        if self._socket is not None and _QUICKACK is not None:
            # uvloop's wrapper of a closed socket raises ValueError; a `with` would cost twice as much.
            try:  # noqa: SIM105
                self._socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
            except (OSError, ValueError):
                pass

    def get_buffer(self, sizehint: int) -> memoryview:
        """Return the buffer for the next read, which all connections of the event loop share."""
        return self._buffer[: self._turn.size_bytes]

    def buffer_updated(self, nbytes: int) -> None:
        """Deliver received bytes."""
        if nbytes < MIN_READ_BYTES:
            self._deliver(bytes(self._buffer[:nbytes]))
            self._turn.note_quiet()
            return
        began_s = thread_time()
        self._deliver(bytes(self._buffer[:nbytes]))
        self._turn.note_cost(nbytes, thread_time() - began_s)


class TcpListener:
    """Listens for boards, and creates a transport for each; created by `start`."""

    def __init__(
        self,
        on_transport: Callable[[Transport], None],
        allow: AllowList,
        max_connections: int,
        max_connections_per_host: int,
        greeting: Greeting | None = None,
    ) -> None:
        self._on_transport = on_transport
        self._allow = allow
        self._greeting = greeting
        self._greetings: set[asyncio.Task[None]] = set()
        # Connections without a proven key, in their order of arrival.
        self._unproven: dict[TcpTransport, None] = {}
        self._boards: set[TcpTransport] = set()
        self._max_connections = max_connections
        self._max_connections_per_host = max_connections_per_host
        self._transports: set[TcpTransport] = set()
        self._per_host: Counter[str] = Counter()
        self._server: asyncio.Server | None = None
        self._is_closed = False
        self.address = ""
        self.refusals = RefusalLog("tcp listener", asyncio.get_running_loop().time)

    @classmethod
    async def start(
        cls,
        address: TcpAddress,
        on_transport: Callable[[Transport], None],
        *,
        max_connections: int = MAX_CONNECTIONS,
        max_connections_per_host: int = MAX_CONNECTIONS_PER_HOST,
        board_keys: BoardKeys = NO_KEYS,
    ) -> TcpListener:
        """Listen.

        Raises TransportOpenError if the port is in use or the host is not an address of this machine. Raises
        ConfigError for a key or certificate that cannot be read.
        """
        allow = AllowList(address.allow)
        greeting = make_greeting(address, board_keys)
        listener = cls(on_transport, allow, max_connections, max_connections_per_host, greeting)
        try:
            server = listener._server = await start_server(
                lambda: _AcceptedTransport(listener),
                address.host,
                address.port,
                accepted_at_once=_ACCEPTED_AT_ONCE,
            )
        except OSError as error:
            raise explain_bind_error("tcp", address.host, address.port, error) from error
        host, port = server.sockets[0].getsockname()[:2]
        listener.address = str(replace(address, host=host, port=port))
        listener.refusals = RefusalLog(listener.address, asyncio.get_running_loop().time)
        return listener

    @property
    def connection_count(self) -> int:
        """How many connections are open now, with those that have not proven their key."""
        return len(self._transports)

    async def close(self) -> None:
        """Stop listening and end all its transports. Idempotent."""
        if self._server is None:
            return
        server, self._server = self._server, None
        self._is_closed = True
        await close_servers([server])
        ending = list(self._transports)
        for transport in ending:
            transport.close()
        for transport in ending:
            await transport.wait_closed()
        if self._greetings:
            await asyncio.wait(list(self._greetings))
        await server.wait_closed()

    def _accepted(self, transport: TcpTransport) -> None:
        if self._is_closed:
            # The connection was accepted just before the listener closed; this needs no report.
            transport.abort()
            return
        reason = self._refusal_reason(transport.host, transport.own_host)
        if reason is not None:
            self.refusals.refuse(transport.peer, reason)
            transport.abort()
            return
        self._transports.add(transport)
        if self._greeting is None:
            self._admit(transport)
            return
        self._make_room(transport.host)
        self._unproven[transport] = None
        start_task(self._greetings, self._check_greeting(transport, self._greeting))

    def _make_room(self, host: str) -> None:
        """End the oldest unproven connection of the address, or of all, if there are too many."""
        same = [each for each in self._unproven if each.host == host]
        if len(same) >= MAX_UNPROVEN_PER_HOST:
            self._end_unproven(same[0], f"{host} has {MAX_UNPROVEN_PER_HOST} unauthenticated connections")
        elif len(self._unproven) >= MAX_UNPROVEN:
            self._end_unproven(
                next(iter(self._unproven)), f"there are {MAX_UNPROVEN} unauthenticated connections"
            )

    def _end_unproven(self, transport: TcpTransport, reason: str) -> None:
        del self._unproven[transport]
        self.refusals.refuse(transport.peer, reason)
        transport.abort()

    async def _check_greeting(self, transport: TcpTransport, greeting: Greeting) -> None:
        reason: str | None
        try:
            transport.proof = await greeting.exchange(transport)
            reason = self._full_reason(transport.host)
        except RostetherError as error:
            reason = str(error)
        if transport not in self._unproven:
            # A newer connection has replaced this one in the meantime, which was reported.
            return
        del self._unproven[transport]
        if reason is None:
            self._admit(transport)
        else:
            self.refusals.refuse(transport.peer, reason)
            transport.abort()

    def _refusal_reason(self, host: str, own_host: str) -> str | None:
        if not self._allow.allows_connection(host, own_host):
            return "its address is not in allow="
        return self._full_reason(host)

    def _full_reason(self, host: str) -> str | None:
        if len(self._boards) >= self._max_connections:
            return f"the limit of connected boards ({self._max_connections}) is reached"
        if self._per_host[host] >= self._max_connections_per_host:
            return f"the limit of connections from one address ({self._max_connections_per_host}) is reached"
        return None

    def _admit(self, transport: TcpTransport) -> None:
        self._boards.add(transport)
        self._per_host[transport.host] += 1
        self._on_transport(transport)

    def _forget(self, transport: TcpTransport) -> None:
        self._transports.discard(transport)
        if transport in self._boards:
            self._boards.remove(transport)
            self._per_host[transport.host] -= 1
            if not self._per_host[transport.host]:
                del self._per_host[transport.host]


class _AcceptedTransport(TcpTransport):
    def __init__(self, listener: TcpListener) -> None:
        super().__init__()
        self._listener = listener

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._listener._accepted(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._listener._forget(self)
        super().connection_lost(exc)


async def connect_tcp(address: TcpAddress) -> TcpTransport:
    """Connect to a peer. Raises TransportOpenError, TransportTimeoutError, ConfigError."""
    greeting = make_greeting(address)
    endpoint = show_endpoint(address.host, address.port)
    loop = asyncio.get_running_loop()
    try:
        async with asyncio.timeout(CONNECT_LIMIT_S):
            _, transport = await loop.create_connection(
                lambda: TcpTransport(f"tcp {endpoint}"), address.host, address.port
            )
    except TimeoutError as error:
        raise TransportTimeoutError(
            f"{endpoint} does not answer within {CONNECT_LIMIT_S:g} s; check its address and its network"
        ) from error
    except OSError as error:
        raise explain_connect_error(endpoint, error) from error
    if greeting is not None:
        try:
            await greeting.exchange(transport)
        except BaseException as error:
            transport.abort()
            if isinstance(error, RostetherError):
                raise TransportOpenError(f"{endpoint}: {error}") from None
            raise
    return transport


def make_greeting(address: TcpAddress, board_keys: BoardKeys = NO_KEYS) -> Greeting | None:
    """Return the greeting that an address requires before a board's first byte. Raises ConfigError."""
    if address.psk is None and address.tls is None:
        return None
    from rostether.transports.greeting import Greeting  # only needed with a key or TLS

    return Greeting(address.psk, address.tls, listens=address.listens, host=address.host, boards=board_keys)
