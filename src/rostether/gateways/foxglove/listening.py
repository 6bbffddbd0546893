"""Where clients connect, and which connections are hung up on at once."""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Callable

from rostether.errors import ConfigError
from rostether.gateways.foxglove.admission import Admission
from rostether.gateways.foxglove.line import Line, LineUser
from rostether.gateways.foxglove.settings import DEFAULT_HOST, FoxgloveSettings
from rostether.transports.allow_list import AllowList


class Listening:
    """The listeners of one gateway; `make_user` makes the client of a new connection."""

    def __init__(
        self,
        settings: FoxgloveSettings,
        make_user: Callable[[Line], LineUser],
        tell_refused: Callable[[str], None],
    ) -> None:
        self._settings = settings
        self._make_user = make_user
        self._tell_refused = tell_refused
        self._admission = Admission(settings.origins, settings.token)
        self._allowed = AllowList(settings.allow)
        self._servers: list[asyncio.Server] = []
        self._lines: set[_Counted] = set()
        self._is_closed = False

    @property
    def port(self) -> int:
        """The port that is listened on; zero before the start."""
        sockets = self._servers[0].sockets if self._servers else ()
        return int(sockets[0].getsockname()[1]) if sockets else 0

    async def start(self) -> None:
        """Listen. Raises ConfigError when the port is taken or the certificate cannot be used."""
        host = self._settings.host
        hosts = ["127.0.0.1", "::1"] if host == DEFAULT_HOST else [host or None]
        encryption = _encryption(self._settings)
        port = self._settings.port
        loop = asyncio.get_running_loop()
        for each in hosts:
            try:
                server = await loop.create_server(self._connect, each, port, ssl=encryption)
            except OSError as error:
                if self._servers:
                    # A machine without IPv6.
                    continue
                raise ConfigError(
                    f"cannot listen on {host}:{port} for Foxglove: {error.strerror or error}; "
                    "give another port, or end what uses it"
                ) from error
            self._servers.append(server)
            port = self.port

    def close(self) -> None:
        """Take nobody any more; who is connected stays."""
        self._is_closed = True
        for server in self._servers:
            server.close()

    async def hang_up(self, timeout_s: float) -> None:
        """Say good-bye to all connections, and cut those that do not answer in time."""
        for line in list(self._lines):
            line.close()
        ended = [line.ended for line in self._lines]
        if ended:
            await asyncio.wait(ended, timeout=timeout_s)
        for line in list(self._lines):
            line.abort()
        if ended:
            await asyncio.wait(ended)

    def _connect(self) -> Line:
        line = _Counted(self, self._admission, self._settings, self._tell_refused)
        line.user = self._make_user(line)
        return line

    def takes(self, line: _Counted, peer: str, own: str) -> bool:
        """Tell whether a connection may stay, and count it."""
        if self._is_closed or len(self._lines) >= self._settings.limits.clients:
            return False
        if not self._allowed.allows_connection(peer, own):
            self._tell_refused(f"{peer} may not connect: allow it with --allow {peer}")
            return False
        self._lines.add(line)
        return True

    def forget(self, line: _Counted) -> None:
        """Take a connection's end."""
        self._lines.discard(line)


class _Counted(Line):
    """A line that counts as soon as it is there: who never shakes hands takes a place, too."""

    def __init__(
        self,
        listening: Listening,
        admission: Admission,
        settings: FoxgloveSettings,
        tell_refused: Callable[[str], None],
    ) -> None:
        super().__init__(admission, settings.limits, tell_refused)
        self.ended: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._listening = listening

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Look who it is."""
        super().connection_made(transport)
        peer, own = (transport.get_extra_info(name) or ("",) for name in ("peername", "sockname"))
        if not self._listening.takes(self, str(peer[0]), str(own[0])):
            self.abort()

    def connection_lost(self, error: Exception | None) -> None:
        """Free the place."""
        super().connection_lost(error)
        self._listening.forget(self)
        self.ended.set_result(None)


def _encryption(settings: FoxgloveSettings) -> ssl.SSLContext | None:
    if not settings.certificate:
        return None
    try:
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(settings.certificate, settings.key or None)
    except (OSError, ssl.SSLError) as error:
        raise ConfigError(
            f"the certificate {settings.certificate} and its key cannot be used: {error.strerror or error}"
        ) from error
    return context
