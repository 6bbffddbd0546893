"""One connection of a WebSocket server: handshake or plain request, messages, pings, and close.

The library websockets implements the protocol, without I/O.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from contextlib import aclosing
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Protocol

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.extensions.permessage_deflate import ServerPerMessageDeflateFactory
from websockets.frames import CloseCode, Frame, Opcode
from websockets.http11 import Request, Response
from websockets.protocol import OPEN
from websockets.server import ServerProtocol
from websockets.typing import Subprotocol

from rostether.gateways.websocket.connection_limiter import peer_name
from rostether.gateways.websocket.message_assembler import MessageAssembler
from rostether.gateways.websocket.ping_watch import PingWatch
from rostether.gateways.websocket.plain_response import (
    MAX_METHOD_BYTES,
    asks_for_websocket,
    download_chunks,
    malformed_reply,
    plain_response,
)
from rostether.gateways.websocket.site import Site, refusal
from rostether.gateways.websocket.tls_start import encrypted
from rostether.transports.read_turn import ReadTurn
from rostether.transports.sockets import READ_BYTES, read_buffer

if TYPE_CHECKING:
    import ssl

    from rostether.gateways.websocket.server import WebSocketServer

# The time for a client to answer a close; then the connection is aborted.
_CLOSE_S = 5.0

# Long enough for a phone on a weak network to read the largest file of the page.
_FILE_S = 30.0

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


class Connection(asyncio.BufferedProtocol):
    """One connection; it gets a user when the handshake ends.

    It reads less at a time while its chunks cost much: 128 KiB can hold 20,000 frames.
    """

    def __init__(self, server: WebSocketServer) -> None:
        self.path = "/"
        self.headers = Headers()
        # The client's address, and whether it is one of this machine.
        self.host = ""
        self.is_local = False

        # Set when the client has read most of the sent data, and when the connection has ended.
        self.has_room = asyncio.Event()
        self.has_room.set()
        self._server = server
        self._limits = server.limits
        self._websocket = ServerProtocol(
            subprotocols=[Subprotocol(each) for each in server.subprotocols],
            select_subprotocol=_choose_subprotocol,
            extensions=[ServerPerMessageDeflateFactory()] if server.deflates else None,
            max_size=self._limits.message_bytes,
        )
        self._loop = asyncio.get_running_loop()
        self._transport: asyncio.Transport | None = None
        self._user: ConnectionUser | None = None
        self._buffer = read_buffer()
        self._turn = ReadTurn(READ_BYTES)
        self._assembler = MessageAssembler()
        self._is_reading = True
        # What arrives between the TLS handshake and the encrypted transport; None from then on.
        self._early: bytearray | None = None
        self._encrypting: asyncio.Task[None] | None = None
        self._is_shaken = False
        self._timer: asyncio.TimerHandle | None = None
        self._is_ending = False
        self._is_answered = False
        self._start = b""
        self._download: asyncio.Task[None] | None = None
        # The answer to the last ping of a client that does not read.
        self._pong = b""
        self._pings = PingWatch(self._limits.pings)

    @property
    def is_open(self) -> bool:
        """Whether messages can be sent."""
        # An invalid frame in the chunk of the request ends sending, but the state becomes open.
        return self._is_shaken and self._websocket.state is OPEN and not self._websocket.eof_sent

    @property
    def is_newcomer(self) -> bool:
        """Whether it has not sent a whole request yet."""
        return not self._is_shaken and not self._is_answered

    @property
    def unsent_bytes(self) -> int:
        """The bytes that the socket has not accepted yet."""
        return self._transport.get_write_buffer_size() if self._transport is not None else 0

    @property
    def peer(self) -> str:
        """The client's address as text."""
        return peer_name(self._transport) if self._transport is not None else "a client"

    @property
    def fault(self) -> str:
        """The client's error, if the server closed the connection because of it."""
        sent = self._websocket.close_sent
        return "" if sent is None or sent.code in _ORDERLY else sent.reason or str(sent.code)

    # Methods that asyncio calls.

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Wait for the request, if the connection is admitted; encrypt it first if the server does that."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        peer, own = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if peer and own:
            self.host, self.is_local = peer[0], peer[0] == own[0]
        transport.set_write_buffer_limits(high=self._limits.unsent_bytes)
        if not self._server.admit(self, transport):
            self.abort()
            return
        self._set_timer(self._limits.handshake_s, self.abort)
        if (context := self._server.encryption) is not None:
            self._early = bytearray()
            transport.pause_reading()
            self._encrypting = asyncio.ensure_future(self._encrypt(transport, context))

    def get_buffer(self, sizehint: int) -> memoryview:
        """Lend the event loop's read buffer until `buffer_updated`."""
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
        if self._is_answered:
            # One connection, one plain request; its body is read, so that the client gets the response.
            return
        if not self._is_shaken:
            self._start = (self._start + data[:MAX_METHOD_BYTES])[:MAX_METHOD_BYTES]
        self._websocket.receive_data(data)
        self._handle_events()

    def eof_received(self) -> bool:
        """Handle the end of the client's data."""
        if self._early is not None:
            return False
        if self._is_answered and self._download is None:
            return False
        if self._download is not None:
            # TLS has no half-closed connections.
            return self._transport is not None and self._transport.can_write_eof()
        self._websocket.receive_eof()
        self._handle_events()
        return False

    def connection_lost(self, _: Exception | None) -> None:
        """Report the end to the user."""
        if self._timer is not None:
            self._timer.cancel()
        if self._download is not None:
            self._download.cancel()
        self._is_shaken = False
        self.has_room.set()
        user, self._user = self._user, None
        if user is not None:
            user.closed()
        self._server.forget(self)

    def pause_writing(self) -> None:
        """Pause the user."""
        self.has_room.clear()
        if self._user is not None:
            self._user.paused()

    def resume_writing(self) -> None:
        """Resume the user."""
        self.has_room.set()
        pong, self._pong = self._pong, b""
        self.write(pong)
        if self._user is not None:
            self._user.resumed()

    # Methods for the user.

    def pause_reading(self) -> None:
        """Read no more, so that the client waits."""
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
        """Write complete frames that the user has built."""
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

    async def _encrypt(self, transport: asyncio.Transport, context: ssl.SSLContext) -> None:
        wire = await encrypted(transport, self, context, self._limits.handshake_s)
        early, self._early = self._early, None
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
        if self._websocket.handshake_exc is not None and not self._is_shaken and not self._is_answered:
            self._refuse_malformed()
        if self._is_answered:
            # The library would parse the body as WebSocket frames.
            return
        self._write_protocol()
        if self._websocket.close_expected() and not self._is_ending:
            # The client gets the reason (RFC 6455, 7.4), then one side closes; data does not extend the time.
            self._is_ending = True
            self._set_timer(_CLOSE_S, self.abort)

    def _refuse_malformed(self) -> None:
        if self._server.site is not None and (reply := malformed_reply(self._server.site, self._start)):
            self._answer(plain_response(reply), self._limits.handshake_s)

    def _handle_request(self, request: Request) -> None:
        self.path, self.headers = request.path, request.headers
        if self._server.site is not None and not asks_for_websocket(request):
            self._serve_file(request)
            return
        refused = self._server.refusal(self, request)
        if refused is not None:
            status, reason = refused
            self._answer(self._websocket.reject(status, reason + "\n"), self._limits.handshake_s)
            return
        response = self._websocket.accept(request)
        if response.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            self._answer(response, self._limits.handshake_s)
            return
        self._websocket.send_response(response)
        self._write_protocol()
        self._set_timer(self._limits.ping_period_s, self._ping)
        self._is_shaken = True
        self._user = self._server.open_user(self)

    def _serve_file(self, request: Request) -> None:
        assert self._server.site is not None
        # Before websockets 17, only GET reaches this point, and requests have no method.
        method = getattr(request, "method", "GET")
        is_download = self._server.site.is_download(method, request.path)
        refused = self._server.download_refusal if is_download else self._server.page_refusal
        if (reason := refused(self, request)) is not None:
            reply = refusal(HTTPStatus.FORBIDDEN, reason)
        elif is_download:
            self._is_answered = self._is_ending = True
            self._set_timer(_FILE_S, self.abort)
            self._download = asyncio.ensure_future(self._send_download(self._server.site, request.path))
            return
        else:
            reply = self._server.site.reply(method, request.path, request.headers)
        self._answer(plain_response(reply), _FILE_S)

    def _answer(self, response: Response, limit_s: float) -> None:
        """Answer a plain request, or refuse a WebSocket; then the client closes."""
        assert self._transport is not None
        self._is_answered = self._is_ending = True
        self._transport.write(response.serialize())
        self._end_sending()
        self._set_timer(limit_s, self.abort)

    async def _send_download(self, site: Site, path: str) -> None:
        assert self._transport is not None
        # A canceled download closes its file.
        async with aclosing(download_chunks(site, path)) as chunks:
            async for chunk in chunks:
                self._transport.write(chunk)
                # A client that reads nothing for this time has disconnected.
                self._set_timer(_FILE_S, self.abort)
                await self.has_room.wait()
        # The transport sends written data first.
        self._transport.close()

    def _handle_frame(self, frame: Frame) -> None:
        self._pings.received()
        try:
            message = self._assembler.receive_frame(frame)
        except UnicodeDecodeError as error:
            if self.is_open:
                self._websocket.fail(CloseCode.INVALID_DATA, f"{error.reason} at position {error.start}")
            return
        # A client may send messages and close at once: its close frame has been read, and comes after them.
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
            self._end_sending()

    def _end_sending(self) -> None:
        assert self._transport is not None
        # TLS has no half-close; the transport sends written data first.
        if self._transport.can_write_eof():
            self._transport.write_eof()
        else:
            self._transport.close()

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
