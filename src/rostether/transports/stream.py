"""The transport over an asyncio byte stream, shared by TCP and serial ports."""

from __future__ import annotations

import asyncio
import errno
import ssl
from typing import cast

from rostether.errors import PeerClosedError, TransportClosedError, TransportError
from rostether.transports.sockets import explain_reason
from rostether.transports.tls import HANDSHAKE_LIMIT_S
from rostether.transports.transport import PausingTransport, Receiver

# A board that does not read must not delay the end of this process: later data is lost.
FLUSH_LIMIT_S = 1.0
# About 900 frames with payloads of 64 bytes: the cost of a wake-up is negligible, and the chunk of a flooding
# board takes only a few milliseconds, so that others get their turn.
READ_CHUNK_BYTES = 64 * 1024


class StreamTransport(PausingTransport, asyncio.BaseProtocol):
    """One open byte stream as a `Transport`; created by the modules of TCP and serial ports."""

    def __init__(self, peer: str, *, can_pause: bool) -> None:
        super().__init__()
        self.peer = peer
        self.can_pause = can_pause
        self._wire: asyncio.Transport | None = None
        self._early = bytearray()
        self._wants_reading = True
        self._is_closing = False
        self._is_lost = False
        self._error: TransportError | None = None
        self._flush_limit: asyncio.TimerHandle | None = None
        self._ended = asyncio.get_running_loop().create_future()

    def peer_certificate(self) -> bytes | None:
        """Return the certificate with which the peer has authenticated, in DER form."""
        tls = None if self._wire is None else self._wire.get_extra_info("ssl_object")
        return None if tls is None else tls.getpeercert(binary_form=True)

    @property
    def write_buffer_bytes(self) -> int:
        """The number of written bytes that are still waiting."""
        if self._wire is None or self._is_lost:
            return 0
        return self._wire.get_write_buffer_size()

    def start(self, receiver: Receiver) -> None:
        """Start to deliver; called once, and again after `release`. Bytes received earlier are kept."""
        self._receiver = receiver
        if self._is_lost or self._early:
            asyncio.get_running_loop().call_soon(self._catch_up)
        if self._is_writing_paused and not self._is_lost:
            receiver.pause_writing()
        self._apply_reading()

    def release(self, unread: bytes = b"") -> None:
        """Stop delivering until the next `start`, which then receives `unread` first."""
        self._receiver = None
        self._wants_reading = True
        self._early[:0] = unread
        if self._wire is not None and not self._is_lost and not self._is_closing:
            self._wire.pause_reading()

    async def start_tls(self, context: ssl.SSLContext, *, listens: bool, host: str = "") -> None:
        """Encrypt all further bytes; call it before `start`. Raises OSError if the handshake fails."""
        assert self._wire is not None
        closed = ConnectionAbortedError(errno.ECONNABORTED, "the connection was closed")
        # asyncio would wait for the handshake of a closed connection until the limit, with a large buffer.
        if self._wire.is_closing():
            raise closed
        wire = None
        try:
            wire = await asyncio.get_running_loop().start_tls(
                self._wire,
                self,
                context,
                server_side=listens,
                server_hostname=None if listens else host,
                ssl_handshake_timeout=HANDSHAKE_LIMIT_S,
            )
        finally:
            # Until the handshake ends, asyncio does not report that the connection was lost.
            if wire is None:
                self.connection_lost(None)
        # asyncio returns None if the connection is closed during the handshake.
        if wire is None:
            raise closed
        # Bytes right after the handshake have paused the socket, which TLS controls now.
        self._wire.resume_reading()
        self._wire = wire
        wire.pause_reading()

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Queue bytes. Never blocks; does nothing once the transport has ended."""
        if self._is_closing or self._is_lost or self._wire is None:
            return
        self._wire.write(data)

    def pause_reading(self) -> None:
        """Deliver nothing until resume_reading. Idempotent."""
        self._wants_reading = False
        self._apply_reading()

    def resume_reading(self) -> None:
        """Deliver again. Idempotent."""
        self._wants_reading = True
        if self._early and self._receiver is not None:
            asyncio.get_running_loop().call_soon(self._catch_up)
        self._apply_reading()

    def close(self) -> None:
        """Flush queued data for at most a second, then close. Idempotent."""
        if self._is_closing:
            return
        self._is_closing = True
        if self._wire is not None and not self._is_lost:
            if self._flush_limit is None:
                self._flush_limit = asyncio.get_running_loop().call_later(FLUSH_LIMIT_S, self.abort)
            self._end_wire(self._wire)

    def abort(self) -> None:
        """Close immediately; queued data is lost. Idempotent."""
        self._is_closing = True
        if self._wire is not None and not self._is_lost:
            self._wire.abort()

    async def wait_closed(self) -> None:
        """Wait until the transport has ended."""
        await asyncio.shield(self._ended)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep asyncio's transport; reading waits for `start`."""
        self._wire = cast(asyncio.Transport, transport)
        self._wire.pause_reading()

    def connection_lost(self, exc: Exception | None) -> None:
        """Pass on the end of the stream, once."""
        if self._is_lost:
            return
        self._is_lost = True
        if self._flush_limit is not None:
            self._flush_limit.cancel()
        if not self._is_closing:
            self._error = self._explain_loss(exc)
        if not self._ended.done():
            self._ended.set_result(None)
        if self._early:
            asyncio.get_running_loop().call_soon(self._catch_up)
        elif self._receiver is not None:
            self._receiver.connection_lost(self._error)

    def eof_received(self) -> bool:
        """Close this side when the peer closes its side: it may never read again."""
        if self._flush_limit is None and self._wire is not None:
            self._flush_limit = asyncio.get_running_loop().call_later(FLUSH_LIMIT_S, self._wire.abort)
        return False

    def _deliver(self, data: bytes) -> None:
        if self._receiver is not None:
            self._receiver.data_received(data)
        elif self._wire is not None:
            # uvloop starts to read after connection_made, and so ignores a pause in connection_made.
            self._early += data
            self._wire.pause_reading()

    def _catch_up(self) -> None:
        receiver = self._receiver
        if receiver is None:
            return
        if self._early and (self._wants_reading or self._is_lost) and not self._is_closing:
            early = bytes(self._early)
            self._early.clear()
            receiver.data_received(early)
            self._apply_reading()
        if self._is_lost:
            self._receiver = None
            receiver.connection_lost(self._error)

    def _end_wire(self, wire: asyncio.Transport) -> None:
        wire.close()

    def _explain_loss(self, exc: Exception | None) -> TransportError:
        if exc is None:
            return PeerClosedError(f"{self.peer} ended the connection; it may connect again")
        return TransportClosedError(
            f"{self.peer} ended the connection ({explain_reason(exc)}); it may connect again"
        )

    def _apply_reading(self) -> None:
        wire = self._wire
        if wire is None or self._receiver is None or self._is_closing or self._is_lost:
            return
        if self._wants_reading and not self._early:
            wire.resume_reading()
        else:
            wire.pause_reading()
