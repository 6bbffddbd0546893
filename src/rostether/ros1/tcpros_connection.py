"""The common part of all TCPROS connections: the exchange of headers, socket options and counters."""

from __future__ import annotations

import asyncio
import itertools
import socket
from collections.abc import Callable, Mapping
from typing import TypeAlias, cast

from rostether.errors import RemoteProtocolError, RostetherError, TransportOpenError, TransportTimeoutError
from rostether.mechanisms.text import show_endpoint
from rostether.ros1.environment import connect_host
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.tcpros.header import HeaderDecoder, encode_header
from rostether.transports.sockets import explain_reason, limit_unsent

# A healthy peer answers in milliseconds; over a bad radio link, TCP retransmits a lost packet within 3 s.
CONNECT_TIMEOUT_S = 10.0

# The unsent data of one subscriber in the kernel: 10 ms of a flood. More could not be dropped, and would hide
# that the subscriber is behind.
UNSENT_BYTES = 128 << 10

# A peer that reads gets the rest within milliseconds; one that hangs must not delay the end.
CLOSE_GRACE_S = 1.0

# Nearly all headers are smaller; larger ones are counted together, so that many cannot fill the memory.
_LARGE_HEADER_BYTES = 64 << 10

# As rospy and roscpp set them: a peer that disappeared without closing is detected after 2.5 minutes.
_KEEPALIVE = (("TCP_KEEPIDLE", 60), ("TCP_KEEPINTVL", 10), ("TCP_KEEPCNT", 9))

_next_id = itertools.count(1)

Accept: TypeAlias = Callable[[dict[str, str], asyncio.Transport], asyncio.Protocol]

Admit: TypeAlias = "Callable[[HandshakeProtocol, asyncio.Transport], bool]"


class HandshakeProtocol(asyncio.Protocol):
    """Reads the first header of a connection, then hands the transport to the protocol `accept` returns.

    `accept` runs immediately, so that no byte of the peer is lost. It does not write: the protocol that it
    returns does so in `connection_made`. That protocol is the result of `outcome`. An error that `accept`
    raises ends the connection and is the exception of `outcome`; the peer of an incoming connection receives
    its text first.
    A connection that `admit` refuses is closed. A large header is read only while `has_room` returns True.
    """

    def __init__(
        self,
        accept: Accept,
        *,
        request: Mapping[str, str] | None = None,
        admit: Admit | None = None,
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
        has_room: Callable[[], bool] = lambda: True,
    ) -> None:
        self._accept = accept
        self._has_room = has_room
        self._admit = admit
        self.host = ""
        self._request = request
        self._decoder = HeaderDecoder(limits.header_bytes)
        loop = asyncio.get_running_loop()
        self.outcome: asyncio.Future[asyncio.Protocol] = loop.create_future()
        self._transport: asyncio.Transport | None = None
        self._timeout = loop.call_later(
            limits.header_s,
            self._fail,
            TransportTimeoutError(f"no connection header within {limits.header_s:g} s"),
        )

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Send our header first on an outgoing connection."""
        # uvloop's transports are not subclasses of asyncio's.
        self._transport = cast(asyncio.Transport, transport)
        peer = transport.get_extra_info("peername")
        self.host = peer[0] if peer else ""
        if self._admit is not None and not self._admit(self, self._transport):
            self._fail(RemoteProtocolError("refused"))
            return
        set_keepalive(self._transport)
        if self._request is not None:
            self._transport.write(encode_header(self._request))

    def data_received(self, data: bytes) -> None:
        """Collect the header."""
        assert self._transport is not None
        if self.outcome.done():
            return
        try:
            fields = self._decoder.feed(data)
            if fields is None:
                if self.held_bytes > _LARGE_HEADER_BYTES and not self._has_room():
                    self._fail(RemoteProtocolError("too many large connection headers at once"))
                return
            successor = self._accept(fields, self._transport)
        except RostetherError as error:
            if self._request is None:
                self._transport.write(encode_header({"error": str(error)}))
            self._fail(error)
            return
        self._timeout.cancel()
        self._transport.set_protocol(successor)
        successor.connection_made(self._transport)
        self.outcome.set_result(successor)
        if self._decoder.rest:
            successor.data_received(self._decoder.rest)

    def connection_lost(self, exc: Exception | None) -> None:
        """Fail, because the header is not complete."""
        self._fail(
            exc
            or RemoteProtocolError("the peer closed the connection before its connection header was complete")
        )

    @property
    def held_bytes(self) -> int:
        """The number of bytes of the incomplete header."""
        return self._decoder.held_bytes

    def abort(self) -> None:
        """Abort the connection."""
        self._fail(RemoteProtocolError("the connection was aborted"))

    def _fail(self, error: Exception) -> None:
        self._timeout.cancel()
        if not self.outcome.done():
            self.outcome.set_exception(error)
            # No caller waits for the failure of an incoming connection.
            self.outcome.exception()
        if self._transport is not None:
            self._transport.close()
            # Do not wait for a peer that does not read the refusal.
            asyncio.get_running_loop().call_later(CLOSE_GRACE_S, self._transport.abort)


async def connect(host: str, port: int, request: Mapping[str, str], accept: Accept) -> asyncio.Protocol:
    """Connect, exchange headers and return the protocol that `accept` has created.

    Raises TransportOpenError, TransportTimeoutError, RemoteProtocolError, and the errors of `accept`.
    """
    loop = asyncio.get_running_loop()
    handshake: HandshakeProtocol | None = None
    try:
        async with asyncio.timeout(CONNECT_TIMEOUT_S):
            _, handshake = await loop.create_connection(
                lambda: HandshakeProtocol(accept, request=request), connect_host(host), port
            )
            return await handshake.outcome
    except TimeoutError:
        raise TransportTimeoutError(
            f"{show_endpoint(host, port)} gave no answer for {CONNECT_TIMEOUT_S:g} s"
        ) from None
    except (OSError, UnicodeError, OverflowError) as error:
        reason = explain_reason(error)
        raise TransportOpenError(f"{show_endpoint(host, port)} cannot be reached ({reason})") from error
    finally:
        if handshake is not None and not handshake.outcome.done():
            handshake.abort()


class ConnectionRecord:
    """One connection as getBusInfo and getBusStats report it; `direction` is `i` or `o`."""

    def __init__(self, transport: asyncio.Transport, *, peer: str, topic: str, direction: str) -> None:
        self.id = next(_next_id)
        self.peer = peer
        self.topic = topic
        self.direction = direction
        self.byte_count = 0
        self.message_count = 0
        self._transport = transport

    @property
    def description(self) -> str:
        """The text that rosnode parses to show a connection."""
        local = self._transport.get_extra_info("sockname") or ("?", 0)
        remote = self._transport.get_extra_info("peername") or ("?", 0)
        opened: socket.socket | None = self._transport.get_extra_info("socket")
        number = -1 if opened is None else opened.fileno()
        return f"TCPROS connection on port {local[1]} to [{remote[0]}:{remote[1]} on socket {number}]"


def set_keepalive(transport: asyncio.Transport) -> None:
    """Let the kernel detect a peer that disappeared.

    TCP_NODELAY is asyncio's default. Nagle's algorithm would save nothing, because whole batches are written,
    and delay messages by up to 40 ms.
    """
    opened = transport.get_extra_info("socket")
    if opened is None:
        return
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _KEEPALIVE:
        if option := getattr(socket, name, None):
            opened.setsockopt(socket.IPPROTO_TCP, option, value)


def keep_unsent(transport: asyncio.Transport) -> None:
    """Keep the data for a slow peer in this process, where it can be counted and dropped."""
    limit_unsent(transport, UNSENT_BYTES)
    # The transport's own buffer cannot be dropped either: it may hold the rest of one write, no more.
    transport.set_write_buffer_limits(high=0)
