"""One connection of a WebSocket server: handshake or plain request, messages, pings, and close.

The library websockets implements the protocol, without I/O.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Protocol, cast

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.extensions.permessage_deflate import ServerPerMessageDeflateFactory
from websockets.frames import CloseCode, Frame, Opcode
from websockets.http11 import Request
from websockets.protocol import OPEN
from websockets.server import ServerProtocol
from websockets.typing import Subprotocol

from rostether.gateways.websocket.message_assembler import MessageAssembler
from rostether.gateways.websocket.ping_watch import PingWatch
from rostether.gateways.websocket.plain_answer import (
    MAX_METHOD_BYTES,
    PlainAnswer,
    asks_for_websocket,
    end_sending,
    http_method,
    request_method,
)
from rostether.gateways.websocket.tls_start import encrypted
from rostether.mechanisms.text import show_endpoint
from rostether.transports.read_turn import ReadTurn
from rostether.transports.sockets import limit_unsent, read_buffer

if TYPE_CHECKING:
    import ssl

    from rostether.gateways.websocket.settings import ConnectionLimits, ServedProtocol
    from rostether.gateways.websocket.site import Site
    from rostether.transports.tls import ListenerTls

# A chunk of this size has at most 2,700 frames, which take less than 20 ms; one of `READ_BYTES` takes 150 ms.
_MAX_READ_BYTES = 16 * 1024

# A client that does not answer a close within this time is aborted.
_CLOSE_S = 5.0

# The first byte of a pong.
_PONG = bytes([0x80 | Opcode.PONG])

_ORDERLY = (CloseCode.NORMAL_CLOSURE, CloseCode.GOING_AWAY, CloseCode.NO_STATUS_RCVD)


class ConnectionUser(Protocol):
    """Receives the events of one WebSocket."""

    def received(self, message: str | bytes) -> None:
        """Handle a whole message."""

    def paused(self) -> None:
        """Pause: the client reads slowly, and further messages wait in the process."""

    def resumed(self) -> None:
        """Resume: the client has read most of the sent data."""

    def closed(self) -> None:
        """Handle the end of the connection."""


class ConnectionServer(Protocol):
    """The part of its server that a connection uses."""

    limits: ConnectionLimits
    protocol: ServedProtocol
    site: Site | None
    encryption: ListenerTls | None

    def admit(self, connection: Connection) -> bool:
        """Return whether a connection may stay, and count it."""

    def forget(self, connection: Connection) -> None:
        """Stop counting a connection that has ended."""

    def refusal(self, connection: Connection, request: Request) -> tuple[HTTPStatus, str] | None:
        """Return the status and reason with which a WebSocket is refused, None if it is admitted."""

    def plain_refusal(self, connection: Connection, request: Request, *, is_download: bool) -> str | None:
        """Return why a plain request for a file or a download is refused, None if it is allowed."""

    def open_user(self, connection: Connection) -> ConnectionUser:
        """Return the `ConnectionUser` of a connection after its handshake."""


class Connection(asyncio.BufferedProtocol):
    """One connection; it gets a `ConnectionUser` when the handshake ends.

    It reads less at a time while its chunks are expensive to process.
    """

    def __init__(self, server: ConnectionServer) -> None:
        self.path = "/"
        self.headers = Headers()
        # The client's address, and whether it is an address of this machine.
        self.host = ""
        self.is_local = False

        # Set when the client has read most of the sent data, and when the connection has ended.
        self.has_room = asyncio.Event()
        self.has_room.set()
        self._server = server
        self._limits = server.limits
        self._websocket = ServerProtocol(
            subprotocols=[Subprotocol(each) for each in server.protocol.subprotocols],
            select_subprotocol=_choose_subprotocol,
            extensions=[ServerPerMessageDeflateFactory()] if server.protocol.deflates else None,
            max_size=self._limits.message_bytes,
        )
        self._loop = asyncio.get_running_loop()
        self._transport: asyncio.Transport | None = None
        self._user: ConnectionUser | None = None
        self._buffer = read_buffer()
        self._turn = ReadTurn(_MAX_READ_BYTES)
        self._assembler = MessageAssembler()
        self._is_reading = True
        # Bytes received before TLS starts, or after its handshake until `_encrypt` continues; else None.
        self._early: bytearray | None = None
        self._encrypting: asyncio.Task[None] | None = None
        self._is_established = False
        self._timer: asyncio.TimerHandle | None = None
        self._is_ending = False
        # The answer to a plain request or a refused handshake, which ends the connection.
        self._answer: PlainAnswer | None = None
        # The first bytes of the request.
        self._start = b""
        # The answer to the last ping of a client that does not read.
        self._pong = b""
        self._pings = PingWatch(self._limits.pings)

    @property
    def is_open(self) -> bool:
        """Whether messages can be sent."""
        # After an invalid frame in the chunk of the request, the state is OPEN although sending has ended.
        return self._is_established and self._websocket.state is OPEN and not self._websocket.eof_sent

    @property
    def is_in_handshake(self) -> bool:
        """Whether the client has not sent a whole request yet."""
        return not self._is_established and self._answer is None

    @property
    def unsent_bytes(self) -> int:
        """The bytes that the socket has not accepted yet."""
        return self._transport.get_write_buffer_size() if self._transport is not None else 0

    @property
    def peer(self) -> str:
        """The client's address as text."""
        address = self._transport.get_extra_info("peername") if self._transport is not None else None
        return show_endpoint(*address[:2]) if address else "a client"

    @property
    def fault(self) -> str:
        """The client's error because of which the server closed the connection, empty if there is none."""
        sent = self._websocket.close_sent
        return "" if sent is None or sent.code in _ORDERLY else sent.reason or str(sent.code)

    # Methods that asyncio calls.

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Wait for the request of an admitted connection, after a TLS handshake if the server uses TLS."""
        # uvloop's transports are not subclasses of asyncio's.
        transport = cast(asyncio.Transport, transport)
        self._transport = transport
        peer, own = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if peer and own:
            self.host, self.is_local = peer[0], peer[0] == own[0]
        # Messages for a slow client wait in the queues of the `ConnectionUser`, which can drop them.
        transport.set_write_buffer_limits(high=self._limits.unsent_bytes)
        limit_unsent(transport, self._limits.unsent_bytes)
        if not self._server.admit(self):
            self.abort()
            return
        self._set_timer(self._limits.handshake_s, self.abort)
        if (encryption := self._server.encryption) is not None:
            self._early = early = bytearray()
            transport.pause_reading()
            self._encrypting = asyncio.ensure_future(self._encrypt(transport, early, encryption.context()))

    def get_buffer(self, sizehint: int) -> memoryview:
        """Return the buffer for the next read, which all connections of the event loop share."""
        return self._buffer[: self._turn.size_bytes]

    def buffer_updated(self, nbytes: int) -> None:
        """Handle bytes."""
        if self._early is not None:
            self._early += self._buffer[:nbytes]
            return
        began_s = time.thread_time()
        self._receive(bytes(self._buffer[:nbytes]))
        self._turn.note_cost(nbytes, time.thread_time() - began_s)

    def _receive(self, data: bytes) -> None:
        if self._answer is not None:
            # A connection answers one plain request. The body is read, so that the client gets the response.
            return
        if not self._is_established:
            self._start = (self._start + data[:MAX_METHOD_BYTES])[:MAX_METHOD_BYTES]
        self._websocket.receive_data(data)
        self._handle_events()

    def eof_received(self) -> bool:
        """Handle the end of the client's data."""
        if self._early is not None:
            return False
        if self._answer is not None:
            # TLS has no half-closed connections.
            is_half_closed = self._transport is not None and self._transport.can_write_eof()
            return self._answer.is_download and is_half_closed
        self._websocket.receive_eof()
        self._handle_events()
        return False

    def connection_lost(self, _: Exception | None) -> None:
        """Report the end to the `ConnectionUser`."""
        if self._timer is not None:
            self._timer.cancel()
        if self._answer is not None:
            self._answer.cancel()
        self._is_established = False
        self.has_room.set()
        user, self._user = self._user, None
        if user is not None:
            user.closed()
        self._server.forget(self)

    def pause_writing(self) -> None:
        """Pause the `ConnectionUser`, because the client reads slowly."""
        self.has_room.clear()
        if self._user is not None:
            self._user.paused()

    def resume_writing(self) -> None:
        """Resume the `ConnectionUser`."""
        self.has_room.set()
        pong, self._pong = self._pong, b""
        self.write(pong)
        if self._user is not None:
            self._user.resumed()

    # Methods for the `ConnectionUser`.

    def pause_reading(self) -> None:
        """Stop reading, so that the client waits."""
        self._is_reading = False
        if self._transport is not None and not self._transport.is_closing():
            self._transport.pause_reading()

    def resume_reading(self) -> None:
        """Read again."""
        self._is_reading = True
        if self._transport is not None and not self._transport.is_closing():
            self._transport.resume_reading()

    def send(self, *messages: str | bytes) -> None:
        """Send messages with one write, unless the connection has ended."""
        if not self.is_open:
            return
        try:
            for message in messages:
                if isinstance(message, str):
                    self._websocket.send_text(message.encode("utf-8", "replace"))
                else:
                    self._websocket.send_binary(message)
        except ConnectionClosed:
            pass
        self._write_protocol()

    def write(self, frames: bytes) -> None:
        """Write complete frames that the `ConnectionUser` has built."""
        if self.is_open and self._transport is not None:
            # Not writelines: in Python 3.12.0 to 3.12.8, 3.13.0 and 3.13.1 it never pauses the writer
            # (CVE-2024-12254).
            self._transport.write(frames)

    def close(self, code: int = CloseCode.GOING_AWAY, reason: str = "") -> None:
        """Close the connection, and abort it if the client does not answer."""
        if not self.is_open:
            if not self._is_ending:
                self.abort()
            return
        self._websocket.send_close(code, reason)
        self._write_protocol()
        self._is_ending = True
        self._set_timer(_CLOSE_S, self.abort)

    def abort(self) -> None:
        """Abort the connection."""
        if self._transport is not None:
            self._transport.abort()

    # Internal methods.

    async def _encrypt(self, transport: asyncio.Transport, early: bytearray, context: ssl.SSLContext) -> None:
        wire = await encrypted(transport, self, early, context, self._limits.handshake_s)
        self._early = None
        if wire is None:
            # asyncio does not report connections that end during the handshake.
            self.connection_lost(None)
            return
        self._transport = wire
        wire.set_write_buffer_limits(high=self._limits.unsent_bytes)
        if early:
            self._receive(bytes(early))

    def _handle_events(self) -> None:
        for event in self._websocket.events_received():
            if isinstance(event, Request):
                self._handle_request(event)
            elif isinstance(event, Frame):
                self._handle_frame(event)
        if self._websocket.handshake_exc is not None and self.is_in_handshake:
            self._refuse_malformed()
        if self._answer is not None:
            # The library may parse the request's body as WebSocket frames, and must not answer it.
            return
        self._write_protocol()
        if self._websocket.close_expected() and not self._is_ending:
            # After the close frames, one side closes the connection (RFC 6455, 7.1.1). Further data does not
            # extend the time.
            self._is_ending = True
            self._set_timer(_CLOSE_S, self.abort)

    def _refuse_malformed(self) -> None:
        site, method = self._server.site, http_method(self._start)
        if site is not None and method:
            self._start_answer().refuse_malformed(site, method, self._limits.handshake_s)

    def _handle_request(self, request: Request) -> None:
        self.path, self.headers = request.path, request.headers
        if (site := self._server.site) is not None and not asks_for_websocket(request):
            is_download = site.is_download(request_method(request), request.path)
            refused = self._server.plain_refusal(self, request, is_download=is_download)
            self._start_answer().send_file(site, request, refused)
            return
        refusal = self._server.refusal(self, request)
        response = self._websocket.accept(request) if refusal is None else self._websocket.reject(*refusal)
        if response.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            self._start_answer().send(response, self._limits.handshake_s)
            return
        self._websocket.send_response(response)
        self._write_protocol()
        self._set_timer(self._limits.ping_period_s, self._ping)
        self._is_established = True
        self._user = self._server.open_user(self)

    def _start_answer(self) -> PlainAnswer:
        assert self._transport is not None
        self._is_ending = True
        self._answer = PlainAnswer(
            self._transport, self.has_room, lambda limit_s: self._set_timer(limit_s, self.abort)
        )
        return self._answer

    def _handle_frame(self, frame: Frame) -> None:
        self._pings.received()
        try:
            message = self._assembler.receive_frame(frame)
        except UnicodeDecodeError as error:
            if self.is_open:
                self._websocket.fail(CloseCode.INVALID_DATA, f"{error.reason} at position {error.start}")
            return
        # A client may send messages and then close: the close frame is already read, and comes after them.
        is_valid = self.is_open or self._websocket.close_rcvd_then_sent
        if message is not None and is_valid and self._user is not None:
            self._user.received(message)

    def _write_protocol(self) -> None:
        if self._transport is None:
            return
        pieces = self._websocket.data_to_send()
        if not self.has_room.is_set():
            # Only the last ping must be answered (RFC 6455, 5.5.3); the pongs of a flood would fill memory.
            self._pong = next((each for each in reversed(pieces) if each.startswith(_PONG)), self._pong)
            pieces = [each for each in pieces if not each.startswith(_PONG)]
        if data := b"".join(pieces):
            self._transport.write(data)
        if b"" in pieces:
            end_sending(self._transport)

    def _ping(self) -> None:
        if self._pings.is_lost(self.unsent_bytes, is_reading=self._is_reading):
            self.abort()
            return
        if self.is_open:
            self._websocket.send_ping(b"")
            self._write_protocol()
            self._set_timer(self._limits.ping_period_s, self._ping)

    def _set_timer(self, delay_s: float, act: Callable[[], Any]) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._loop.call_later(delay_s, act)


def _choose_subprotocol(protocol: ServerProtocol, offered: Sequence[Subprotocol]) -> Subprotocol | None:
    # A client without a subprotocol is accepted: it was written for this protocol.
    return next((each for each in protocol.available_subprotocols or () if each in offered), None)
