"""A WebSocket server: listens, admits connections, and ends them."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from http import HTTPStatus

from websockets.http11 import Request

from rostether.errors import TransportOpenError
from rostether.gateways.websocket.access_rules import AccessRules
from rostether.gateways.websocket.connection import Connection, ConnectionUser
from rostether.gateways.websocket.refusals import Refusals
from rostether.gateways.websocket.settings import (
    DEFAULT_HOST,
    ConnectionLimits,
    ServedProtocol,
    ServerSettings,
)
from rostether.gateways.websocket.site import Site
from rostether.mechanisms.text import show_endpoint
from rostether.transports.address import TlsFiles
from rostether.transports.allow_list import AllowList
from rostether.transports.own_names import OwnNames
from rostether.transports.sockets import (
    close_servers,
    explain_reason,
    start_server,
)
from rostether.transports.tls import ListenerTls

_LOOPBACK_HOSTS = ("127.0.0.1", "::1")
_EVERYWHERE = ("", "0.0.0.0", "::")  # noqa: S104 - compared, not bound

# The share of clients that one address may have: one machine must not keep all others out. The limit does not
# apply to this machine, whose programs share one address.
_HOST_SHARE = 0.5

# The time for clients to answer a close when the server ends: a client that hangs must not delay the end.
CLOSE_LIMIT_S = 2.0


class WebSocketServer:
    """Accepts WebSockets and plain requests at one address.

    Args:
        protocol: The protocol of its WebSockets.
        settings: Where to listen, and who may connect.
        limits: The bounds of the server and its connections.
        open_user: Creates the `ConnectionUser` of a WebSocket after its handshake.
        report_refused: Gets a line, at a limited rate, when a connection is refused.
        site: Files that are served by plain GET.
        routes: For each other path, the function that creates the `ConnectionUser` of its WebSockets; None if
            the path is refused. Programs, this server's pages and pages of `origins` may use these paths, all
            with the full token.
    """

    def __init__(
        self,
        protocol: ServedProtocol,
        settings: ServerSettings,
        limits: ConnectionLimits,
        open_user: Callable[[Connection], ConnectionUser],
        report_refused: Callable[[str], None],
        *,
        site: Site | None = None,
        routes: Mapping[str, Callable[[Connection], ConnectionUser] | None] | None = None,
    ) -> None:
        self.limits = limits
        self.protocol = protocol
        self.site = site
        self.encryption: ListenerTls | None = None
        self._open_user = open_user
        self._routes = routes or {}
        own_names = OwnNames((settings.host, os.environ.get("ROS_HOSTNAME", "")))
        self.access = AccessRules(settings, protocol, own_names)
        self._settings = settings
        self._allow = AllowList(settings.allow)
        self._refusals = Refusals(report_refused)
        self._servers: list[asyncio.Server] = []
        self._connections: dict[Connection, None] = {}
        self._is_closed = False
        self._is_empty = asyncio.Event()

    @property
    def port(self) -> int:
        """The listening port; zero before the start."""
        sockets = self._servers[0].sockets if self._servers else ()
        return int(sockets[0].getsockname()[1]) if sockets else 0

    def url(self, everywhere: str = DEFAULT_HOST) -> str:
        """Return the URL for clients; `everywhere` replaces an address that means all addresses."""
        scheme = "wss" if self._settings.certificate else "ws"
        host = everywhere if self._settings.host in _EVERYWHERE else self._settings.host
        return f"{scheme}://{show_endpoint(host, self.port)}"

    async def start(self) -> None:
        """Listen. Raises TransportOpenError, and ConfigError for an invalid certificate."""
        host, port = self._settings.host, self._settings.port
        hosts = _LOOPBACK_HOSTS if host == DEFAULT_HOST else (host or None,)
        if self._settings.certificate:
            self.encryption = ListenerTls(TlsFiles(self._settings.certificate, self._settings.key or None))
        for each in hosts:
            try:
                server = await start_server(
                    partial(Connection, self), each, port, accepted_at_once=self.limits.clients
                )
            except OSError as error:
                if self._servers:
                    # The machine has no IPv6.
                    continue
                raise self._explain(port, error) from error
            self._servers.append(server)
            port = self.port

    async def close(self) -> None:
        """Stop listening, close all connections, and abort those that do not answer in time. Idempotent."""
        self._is_closed = True
        await close_servers(self._servers)
        for connection in list(self._connections):
            connection.close()
        try:
            async with asyncio.timeout(CLOSE_LIMIT_S):
                await self._wait_until_empty()
        except TimeoutError:
            for connection in list(self._connections):
                connection.abort()
            await self._wait_until_empty()

    async def _wait_until_empty(self) -> None:
        while self._connections:
            self._is_empty.clear()
            await self._is_empty.wait()

    # Methods that connections call.

    def admit(self, connection: Connection) -> bool:
        """Return whether a connection may stay, and count it."""
        if self._is_closed:
            return False
        if reason := self._admission_refusal(connection):
            self._refusals.report(connection.peer, reason)
            return False
        self._connections[connection] = None
        return True

    def _admission_refusal(self, connection: Connection) -> str:
        host, limit = connection.host, self.limits.clients + self.limits.others
        if not host:
            return "it has disconnected"
        if not connection.is_local and not self._allow.allows(host):
            return f"{host} is not in the networks of --allow; add it there"
        if len(self._connections) >= limit and not self._make_room():
            return f"the limit of open connections ({limit}) is reached; close another one"
        return ""

    def _make_room(self) -> bool:
        """End one connection that is not a WebSocket, and return whether there was one.

        It is the oldest of the address that has the most of them. One that has sent no request ends first.
        """
        plain = [each for each in self._connections if not each.is_open]
        if not plain:
            return False
        [(host, _)] = Counter(each.host for each in plain).most_common(1)
        of_host = [each for each in plain if each.host == host]
        oldest = next((each for each in of_host if each.is_in_handshake), of_host[0])
        self.forget(oldest)
        oldest.abort()
        return True

    def forget(self, connection: Connection) -> None:
        """Stop counting a connection that has ended."""
        self._connections.pop(connection, None)
        if not self._connections:
            self._is_empty.set()

    def refusal(self, connection: Connection, request: Request) -> tuple[HTTPStatus, str] | None:
        """Return the status and reason with which a WebSocket is refused, None if it is admitted."""
        route = request.path.partition("?")[0]
        if route not in self._routes:
            refused = self.access.refusal(request.path, request.headers)
        elif self._routes[route] is None:
            refused = HTTPStatus.NOT_FOUND, f"{route} is not offered here"
        else:
            refused = self.access.own_refusal(request.path, request.headers)
        if refused is None and (reason := self._limit_reason(connection)):
            refused = HTTPStatus.SERVICE_UNAVAILABLE, reason
        if refused is None:
            return None
        status, reason = refused
        self._refusals.report(connection.peer, reason)
        return status, reason + "\n"

    def _limit_reason(self, connection: Connection) -> str:
        hosts = [each.host for each in self._connections if each.is_open]
        limit = self.limits.clients
        if len(hosts) >= limit:
            return f"the limit of clients ({limit}) is reached; disconnect another client"
        share = max(1, round(limit * _HOST_SHARE))
        if not connection.is_local and hosts.count(connection.host) >= share:
            return f"the limit of clients from one address ({share}) is reached; disconnect another client"
        return ""

    def open_user(self, connection: Connection) -> ConnectionUser:
        """Return the `ConnectionUser` of a connection after its handshake."""
        open_user = self._routes.get(connection.path.partition("?")[0]) or self._open_user
        return open_user(connection)

    def plain_refusal(self, connection: Connection, request: Request, *, is_download: bool) -> str | None:
        """Return why a plain request for a file or a download is refused, None if it is allowed."""
        if is_download:
            reason = self.access.download_refusal(request.path, request.headers)
        else:
            reason = self.access.page_refusal(request.headers)
        if reason is not None:
            self._refusals.report(connection.peer, reason)
        return reason

    def _explain(self, port: int, error: OSError) -> TransportOpenError:
        host = self._settings.host
        if error.errno == errno.EADDRINUSE:
            problem = (
                f"port {port} is already in use on {host}; stop the program that listens there, or choose "
                "another port"
            )
        elif error.errno == errno.EADDRNOTAVAIL or isinstance(error, socket.gaierror):
            problem = f"{host} is not an address of this machine; 0.0.0.0:{port} listens on all of them"
        elif error.errno == errno.EACCES:
            problem = f"port {port} is reserved for the system; choose a port above 1023"
        else:
            address, reason = show_endpoint(host, port), explain_reason(error)
            problem = f"cannot listen on {address}: {reason}; check the address"
        return TransportOpenError(f"{self.protocol.name}: {problem}")
