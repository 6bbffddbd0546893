"""What comes before a board's first byte on a TCP link: TLS, and the hello with a pre-shared key."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rostether.errors import RostetherError, TransportClosedError, TransportError, TransportTimeoutError
from rostether.transports.psk_hello import PSK_LIMIT_S, ConnectorHello, ListenerHello, read_key
from rostether.transports.sockets import explain_reason
from rostether.transports.stream import StreamTransport
from rostether.transports.tls import TlsFiles, connector_context, listener_context

if TYPE_CHECKING:
    import ssl


class Greeting:
    """One side's part, for many connections; made from files that are read at once. Raises ConfigError."""

    def __init__(self, psk: str | None, tls: TlsFiles | None, *, listens: bool, host: str = "") -> None:
        self._key = None if psk is None else read_key(psk)
        self._listens = listens
        self._host = host
        self._context: ssl.SSLContext | None = None
        if tls is not None:
            self._context = listener_context(tls) if listens else connector_context(tls)

    async def exchange(self, transport: StreamTransport) -> None:
        """Greet over a fresh transport, which afterwards is as fresh as before.

        Raises TransportError or RemoteProtocolError, whose text says what the peer did.
        """
        if self._context is not None:
            try:
                await transport.start_tls(self._context, listens=self._listens, host=self._host)
            except OSError as error:
                reason = getattr(error, "verify_message", None) or getattr(error, "reason", None)
                raise TransportClosedError(
                    f"no TLS connection: {reason or explain_reason(error)}; check the certificates"
                ) from None
        if self._key is not None:
            hello = ListenerHello(self._key) if self._listens else ConnectorHello(self._key)
            await _Hello(transport, hello).finish()


class _Hello:
    """The transport's receiver while the hello lasts."""

    def __init__(self, transport: StreamTransport, hello: ListenerHello | ConnectorHello) -> None:
        self._transport = transport
        self._hello = hello
        self._done: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def finish(self) -> None:
        self._transport.start(self)
        if isinstance(self._hello, ListenerHello):
            self._transport.write(self._hello.greeting)
        try:
            async with asyncio.timeout(PSK_LIMIT_S):
                await self._done
        except TimeoutError:
            raise TransportTimeoutError(
                f"it said no pre-shared-key hello within {PSK_LIMIT_S:g} s; give it the key, see psk="
            ) from None

    def data_received(self, data: bytes) -> None:
        if self._done.done():
            return
        try:
            result = self._hello.receive(data)
        except RostetherError as error:
            self._done.set_exception(error)
            return
        if isinstance(self._hello, ConnectorHello):
            self._transport.write(self._hello.take_answer())
        if result is not None:
            answer, rest = result
            self._transport.write(answer)
            self._transport.release(rest)
            self._done.set_result(None)

    def connection_lost(self, error: TransportError | None) -> None:
        if not self._done.done():
            self._done.set_exception(
                TransportClosedError("it hung up in the pre-shared-key hello; both must have the same key")
            )

    def pause_writing(self) -> None: ...

    def resume_writing(self) -> None: ...
