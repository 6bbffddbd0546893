"""The start of a TCP link before a board's first byte: TLS, and the hello with a pre-shared key."""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Callable

from rostether.errors import (
    ConfigError,
    RostetherError,
    TransportClosedError,
    TransportError,
    TransportTimeoutError,
)
from rostether.transports.address import TlsFiles
from rostether.transports.board_keys import NO_KEYS, NO_PROOF, BoardKeys, Proof
from rostether.transports.psk_hello import PSK_LIMIT_S, ConnectorHello, ListenerHello, read_key
from rostether.transports.sockets import explain_reason
from rostether.transports.stream import StreamTransport
from rostether.transports.tls import (
    SPEAKS_NO_TLS,
    ListenerTls,
    clear_handshake,
    connector_context,
    show_ssl_reason,
)
from rostether.transports.transport import SmallWriter

# `psk=devices`: only the keys that devices.toml has for individual boards.
DEVICES_PSK = "devices"


class Greeting:
    """One side's part of the start of a link, for many connections. The constructor reads the files.

    A listener also accepts the keys and certificates of `boards`, and with `psk=devices` no other key.
    Raises ConfigError.
    """

    def __init__(
        self,
        psk: str | None,
        tls: TlsFiles | None,
        *,
        listens: bool,
        host: str = "",
        boards: BoardKeys = NO_KEYS,
    ) -> None:
        self._keys: dict[str | None, bytes] = {}
        if psk is not None and listens:
            self._keys.update(boards.keys)
        if psk == DEVICES_PSK and listens:
            if not self._keys:
                raise ConfigError(
                    "psk=devices: no board has a key in devices.toml; add psk = FILE to a board there, "
                    "or use psk=FILE in the address"
                )
        elif psk is not None:
            self._keys[None] = read_key(psk)
        self._certificates = {der: path for path, der in boards.certificates.items()}
        self._listens = listens
        self._host = host
        self._context: Callable[[], ssl.SSLContext] | None = None
        if tls is not None and listens:
            self._context = ListenerTls(tls, self._certificates).context
        elif tls is not None:
            own = connector_context(tls)
            self._context = lambda: own

    async def exchange(self, transport: StreamTransport) -> Proof:
        """Greet over a transport before its `start`; return the peer's proof.

        Raises TransportError or RemoteProtocolError with the peer's error.
        """
        if self._context is not None:
            try:
                await transport.start_tls(self._context(), listens=self._listens, host=self._host)
            except OSError as error:
                clear_handshake(error)
                raise TransportClosedError(f"no TLS connection: {_explain_handshake(error)}") from None
        certificate = self._certificates.get(transport.peer_certificate() or b"")
        if not self._keys:
            return Proof(None, certificate)
        if not self._listens:
            await _Hello(transport, ConnectorHello(self._keys[None])).finish()
            return NO_PROOF
        hello = ListenerHello(self._keys)
        await _Hello(transport, hello).finish()
        return Proof(hello.proven, certificate)


def _explain_handshake(error: OSError) -> str:
    if isinstance(error, ssl.SSLError) and error.reason in SPEAKS_NO_TLS:
        return "the other side does not speak TLS; use tls: on both sides"
    if isinstance(error, ssl.SSLCertVerificationError):
        reason = error.verify_message
    elif isinstance(error, ssl.SSLError):
        reason = show_ssl_reason(error)
    elif isinstance(error, ConnectionResetError):
        # asyncio raises it without a text.
        reason = "the other side ended it"
    else:
        reason = explain_reason(error)
    return f"{reason}; check the certificates"


class _Hello(SmallWriter):
    """The transport's receiver during the hello."""

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
                f"it sent no pre-shared-key hello within {PSK_LIMIT_S:g} s; give it the key, see psk="
            ) from None

    def data_received(self, data: bytes) -> None:
        if self._done.done():
            return
        try:
            answer, rest = self._hello.receive(data)
        except RostetherError as error:
            self._done.set_exception(error)
            return
        self._transport.write(answer)
        if rest is not None:
            self._transport.release(rest)
            self._done.set_result(None)

    def connection_lost(self, error: TransportError | None) -> None:
        if not self._done.done():
            self._done.set_exception(
                TransportClosedError(
                    "it closed the connection during the pre-shared-key hello; both sides "
                    "must have the same key"
                )
            )
