"""Where clients connect, and which connections are hung up on at once."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
from collections.abc import Callable

from rostether.errors import ConfigError
from rostether.gateways.connection_limiter import ConnectionLimiter
from rostether.gateways.encryption import server_encryption
from rostether.gateways.foxglove.admission import Admission
from rostether.gateways.foxglove.limits import FoxgloveLimits
from rostether.gateways.foxglove.line import Line, LineUser
from rostether.gateways.foxglove.settings import DEFAULT_HOST, FoxgloveSettings
from rostether.gateways.websocket.site import Site
from rostether.transports.sockets import system_bind_errors


class Listening:
    """The listeners of one gateway; `make_user` makes the client of a new connection."""

    def __init__(
        self,
        settings: FoxgloveSettings,
        make_user: Callable[[Line], LineUser],
        tell_refused: Callable[[str], None],
        site: Site | None = None,
    ) -> None:
        self._settings = settings
        self._site = site
        self._make_user = make_user
        self._admission = Admission(
            settings.origins, settings.token, (settings.host, os.environ.get("ROS_HOSTNAME", ""))
        )
        self.door = ConnectionLimiter(settings.allow, settings.limits.clients, tell_refused)
        """Counts the connections, and reports those that it refuses."""
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
        encryption = server_encryption(self._settings.certificate, self._settings.key)
        port = self._settings.port
        loop = asyncio.get_running_loop()
        for each in hosts:
            try:
                async with system_bind_errors(each, port):
                    server = await loop.create_server(self._connect, each, port, ssl=encryption)
            except OSError as error:
                if self._servers:
                    # A machine without IPv6.
                    continue
                advice = "give another port, or end what uses it"
                if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
                    advice = f"that is no address of this machine, 0.0.0.0:{port} listens on all it has"
                raise ConfigError(
                    f"cannot listen on {host}:{port} for Foxglove: {error.strerror}; {advice}"
                ) from error
            self._servers.append(server)
            port = self.port

    def close(self) -> None:
        """Accept no more connections; existing connections stay."""
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
        line = _Counted(self, self._admission, self._settings.limits, self._site)
        line.user = self._make_user(line)
        return line

    def admit(self, line: _Counted, transport: asyncio.BaseTransport) -> bool:
        """Tell whether a connection may stay, and count it."""
        if self._is_closed or not self.door.admit(transport):
            return False
        self._lines.add(line)
        return True

    def forget(self, line: _Counted) -> None:
        """Take a connection's end."""
        if line in self._lines:
            self._lines.remove(line)
            self.door.release()


class _Counted(Line):
    """A line that counts as soon as it is there: who never shakes hands takes a place, too."""

    def __init__(
        self, listening: Listening, admission: Admission, limits: FoxgloveLimits, site: Site | None
    ) -> None:
        super().__init__(admission, limits, self._tell_refused, site)
        self.ended: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._listening = listening

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Look who it is."""
        super().connection_made(transport)
        if not self._listening.admit(self, transport):
            self.abort()

    def connection_lost(self, error: Exception | None) -> None:
        """Free the place."""
        super().connection_lost(error)
        self._listening.forget(self)
        self.ended.set_result(None)

    def _tell_refused(self, reason: str) -> None:
        if self._transport is not None:
            self._listening.door.report_refusal(self._transport, reason)
