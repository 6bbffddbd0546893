"""Boards on the serial ports of phones and other machines, which the dashboard's page relays by WebSocket.

    board -- serial port -- page in a browser -- WS /serial -- WebTransport -- session

Binary messages are the bytes of the line, both ways. The page's first message is text, `read_hello`. From
then on it reports how many bytes it has written to its port, after each write and at least once a second:
this controls the rate of sending, and shows that the page is alive. Pings do not show that: a browser answers
them while the page's script is stopped.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Protocol

from msgspec.structs import replace

from rostether.errors import PeerClosedError, RemoteProtocolError, TransportClosedError, TransportError
from rostether.transports.address import WebAddress
from rostether.transports.transport import HIGH_WATER_BYTES, LOW_WATER_BYTES, PausingTransport, Receiver
from rostether.transports.web_hello import WebHello, read_hello, read_progress

# A page names its board immediately.
HELLO_LIMIT_S = 5.0
# Pages report once a second. A busy page may be late, but a lost board must be reported within 5 s.
ALIVE_LIMIT_S = 4.0
ALIVE_CHECK_S = 0.5
# A page reads a port in much smaller chunks.
MAX_MESSAGE_BYTES = 64 * 1024
# The unreported bytes: the round trip of a weak network at the speed of a fast port.
WINDOW_BYTES = 16 * 1024
# RFC 6455 (7.4.1).
_NORMAL, _REFUSED, _TRY_LATER = 1000, 1008, 1013
_CONNECTED = '{"op":"connected"}'


class WebSocket(Protocol):
    """The connection to a page, such as `gateways.websocket.connection.Connection`."""

    def send(self, *messages: str | bytes) -> None:
        """Send messages, unless the connection has ended."""

    def pause_reading(self) -> None:
        """Stop reading."""

    def resume_reading(self) -> None:
        """Read again."""

    def close(self, code: int, reason: str = "") -> None:
        """Close after a closing handshake."""

    def abort(self) -> None:
        """Close immediately."""


class WebTransport(PausingTransport):
    """One board behind a page; made by `WebBoards.open`.

    `connect` serves the board that the page names, or returns the reason for a refusal. `forget` is called at
    the end. The transport cannot pause the board: the port loses bytes that the page does not read in time.
    `received`, `paused`, `resumed` and `closed` are the events of the connection to the page.
    """

    can_pause = False

    def __init__(
        self,
        socket: WebSocket,
        connect: Callable[[WebTransport, WebHello], str | None],
        forget: Callable[[WebTransport], None],
    ) -> None:
        super().__init__()
        self.address = WebAddress()
        self.hello: WebHello | None = None
        self._socket = socket
        self._connect = connect
        self._forget = forget
        self._loop = asyncio.get_running_loop()
        self._early: list[bytes] = []
        self._is_reading = True
        self._unsent = bytearray()
        self._sent_bytes = 0
        self._written_bytes = 0
        self._error: TransportError | None = None
        self._ended = asyncio.Event()
        self._received_at_s = self._loop.time()
        self._timer = self._loop.call_later(HELLO_LIMIT_S, self._refuse, "the page did not name its board")

    @property
    def peer(self) -> str:
        """The board's name for users."""
        return f"web {self.hello.name}" if self.hello is not None else "web"

    @property
    def write_buffer_bytes(self) -> int:
        """How many written bytes the page has not written to its port yet."""
        return len(self._unsent) + self._sent_bytes - self._written_bytes

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once. Bytes received earlier are kept."""
        self._receiver = receiver
        if self._is_writing_paused:
            receiver.pause_writing()
        self._loop.call_soon(self._catch_up)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended."""
        if self._ended.is_set():
            return
        self._unsent += data
        self._send()
        if not self._is_writing_paused and self.write_buffer_bytes > HIGH_WATER_BYTES:
            self.pause_writing()

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""
        self._is_reading = False
        self._socket.pause_reading()

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""
        self._is_reading = True
        self._received_at_s = self._loop.time()
        self._loop.call_soon(self._catch_up)

    def close(self) -> None:
        """Send the queued data, then close. Idempotent."""
        if self._ended.is_set():
            return
        # The page still writes this to its port.
        self._socket.send(bytes(self._unsent))
        self._socket.close(_NORMAL, "the bridge closed the line")
        self._end(None)

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""
        await self._ended.wait()

    def received(self, message: str | bytes) -> None:
        """Handle a message of the page."""
        if self._ended.is_set():
            return
        self._received_at_s = self._loop.time()
        try:
            if self.hello is None:
                self._handle_hello(message)
            elif isinstance(message, str):
                self._note_written(read_progress(message))
            elif len(message) > MAX_MESSAGE_BYTES:
                raise RemoteProtocolError(f"a message can have at most {MAX_MESSAGE_BYTES} bytes")
            elif message:
                self._deliver(message)
        except RemoteProtocolError as error:
            self._refuse(str(error))

    def paused(self) -> None:
        """Do nothing: only `WINDOW_BYTES` are unreported."""

    def resumed(self) -> None:
        """Do nothing."""

    def closed(self) -> None:
        """Handle the end of the connection."""
        self._end(
            PeerClosedError(
                f"{self.peer} is disconnected: its page was closed or hidden, or lost its network"
            )
        )

    def admit(self, address: WebAddress, hello: WebHello) -> None:
        """Serve the board that the page has named."""
        # With the prefix, a name from a page never equals that of another node.
        self.address = replace(address, name=address.name or f"web_{hello.name}", baud=hello.baud)
        self.hello = hello
        self._timer.cancel()
        self._timer = self._loop.call_later(ALIVE_CHECK_S, self._check_alive)
        # Reading is paused until the board's node has joined the graph.
        self._socket.pause_reading()
        self._socket.send(_CONNECTED)

    def _handle_hello(self, message: str | bytes) -> None:
        if not isinstance(message, str):
            raise RemoteProtocolError("the first message of a page must name its board, as text")
        reason = self._connect(self, read_hello(message))
        if reason is not None:
            self._socket.close(_TRY_LATER, reason)
            self._end(None)

    def _deliver(self, data: bytes) -> None:
        if self._receiver is None or self._early or not self._is_reading:
            self._early.append(data)
        else:
            self._receiver.data_received(data)

    def _catch_up(self) -> None:
        receiver = self._receiver
        if receiver is None:
            return
        while self._early and (self._is_reading or self._ended.is_set()):
            receiver.data_received(self._early.pop(0))
        if self._ended.is_set():
            self._receiver = None
            receiver.connection_lost(self._error)
        elif self._is_reading:
            self._received_at_s = self._loop.time()
            self._socket.resume_reading()

    def _send(self) -> None:
        room = WINDOW_BYTES - (self._sent_bytes - self._written_bytes)
        if room > 0 and self._unsent:
            chunk = bytes(self._unsent[:room])
            del self._unsent[: len(chunk)]
            self._sent_bytes += len(chunk)
            self._socket.send(chunk)

    def _note_written(self, written_bytes: int) -> None:
        if not self._written_bytes <= written_bytes <= self._sent_bytes:
            raise RemoteProtocolError(
                f"a page must report {self._written_bytes} to {self._sent_bytes} written bytes, "
                f"not {written_bytes}"
            )
        self._written_bytes = written_bytes
        self._send()
        if self._is_writing_paused and self.write_buffer_bytes <= LOW_WATER_BYTES:
            self.resume_writing()

    def _check_alive(self) -> None:
        # A page whose messages are not read cannot report.
        is_read = self._receiver is not None and self._is_reading
        if is_read and self._loop.time() - self._received_at_s > ALIVE_LIMIT_S:
            self._socket.abort()
            self._end(TransportClosedError(f"{self.peer} is disconnected: its page does not answer"))
            return
        self._timer = self._loop.call_later(ALIVE_CHECK_S, self._check_alive)

    def _refuse(self, reason: str) -> None:
        self._socket.close(_REFUSED, reason)
        self._end(TransportClosedError(f"{self.peer} was refused: {reason}"))

    def _end(self, error: TransportError | None) -> None:
        if self._ended.is_set():
            return
        self._error = error
        self._ended.set()
        self._timer.cancel()
        self._unsent.clear()
        self._forget(self)
        if self._receiver is not None:
            self._loop.call_soon(self._catch_up)
