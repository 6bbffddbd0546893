"""The rosbridge server: the v2 protocol of rosbridge over WebSockets, on the graph port.

It serves web pages with roslibjs and programs with roslibpy as rosbridge_suite does. By default it listens
on loopback only.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import socket
from functools import partial
from http import HTTPStatus

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request as HttpRequest
from websockets.http11 import Response

from rostether.errors import RostetherError, TransportOpenError
from rostether.gateways.admission import foreign_host, single_header
from rostether.gateways.connection_limiter import ConnectionLimiter, peer_name
from rostether.gateways.encryption import server_encryption
from rostether.gateways.rosbridge.admission import Admission
from rostether.gateways.rosbridge.gateway_context import GatewayContext, LocalServices, Tell
from rostether.gateways.rosbridge.limited_connection import DoorConnection
from rostether.gateways.rosbridge.message_forms import MessageForms
from rostether.gateways.rosbridge.offered_services import OfferedServices
from rostether.gateways.rosbridge.service_types import AskServer, ServiceTypes
from rostether.gateways.rosbridge.session import Session
from rostether.gateways.rosbridge.settings import (
    DEFAULT_HOST,
    MAX_CLIENTS,
    MAX_GREETING,
    PING_INTERVAL_S,
    PING_LIMIT_S,
    RosbridgeSettings,
)
from rostether.gateways.rosbridge.values import Style
from rostether.gateways.shared_subscriptions import SharedSubscriptions
from rostether.graph.ports import Graph, Level, Publisher
from rostether.msgdef.search_waiting import definitions_searched
from rostether.serde.store import TypeStore
from rostether.transports.sockets import system_bind_errors

CLIENT_COUNT = "client_count"
"""The topic on which rosbridge tells how many clients it has."""

CLOSE_LIMIT_S = 1.0
"""How long a client may take to say good-bye; one that hangs is hung up on."""

MAX_WAITING_FRAMES = 16
"""Frames of one client that are read ahead; then its socket fills, and it is slowed down."""

_LOOPBACK_HOSTS = ("127.0.0.1", "::1")


class RosbridgeServer:
    """A rosbridge server on one node of a graph; the graph stays its owner's."""

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        settings: RosbridgeSettings | None = None,
        *,
        style: Style = Style.ROS1,
        shared: SharedSubscriptions | None = None,
        ask_service_type: AskServer | None = None,
        local_services: LocalServices | None = None,
        tell: Tell = lambda level, text: None,
    ) -> None:
        settings = settings or RosbridgeSettings()
        self._settings = settings
        self._admission = Admission(settings)
        self._tell = tell
        self._around = GatewayContext(
            graph,
            store,
            settings,
            shared=shared or SharedSubscriptions(graph, store),
            forms=MessageForms(store, style, graph.now),
            service_types=ServiceTypes(graph, store, ask_service_type),
            offered=OfferedServices(graph),
            local_services=local_services,
            tell=tell,
        )
        self._servers: list[Server] = []
        self._clients: set[Session] = set()
        self._count_publisher: Publisher | None = None
        self._leaving: asyncio.Task[None] | None = None
        self._ended = asyncio.Event()
        self._door = ConnectionLimiter(
            settings.allow,
            MAX_CLIENTS + MAX_GREETING,
            lambda text: tell(Level.WARN, f"rosbridge: {text}"),
        )

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self._servers[0].sockets[0].getsockname()[1])

    @property
    def uri(self) -> str:
        """What a client on this machine connects to."""
        scheme = "wss" if self._settings.certificate else "ws"
        host = self._settings.host
        if host in ("0.0.0.0", "::", ""):  # noqa: S104 - compared, not bound
            host = DEFAULT_HOST
        return f"{scheme}://{f'[{host}]' if ':' in host else host}:{self.port}"

    @property
    def client_count(self) -> int:
        """How many clients are served now."""
        return len(self._clients)

    async def start(self) -> None:
        """Listen. Raises TransportOpenError, ConfigError."""
        await definitions_searched(self._around.store.registry)
        is_default = self._settings.host == DEFAULT_HOST
        hosts = _LOOPBACK_HOSTS if is_default else (self._settings.host,)
        await self._listen(hosts[0], self._settings.port)
        for host in hosts[1:]:
            # Some programs ask for `localhost` at ::1 alone; a machine may have no IPv6.
            with contextlib.suppress(TransportOpenError):
                await self._listen(host, self.port)
        registry = self._around.store.registry
        with contextlib.suppress(RostetherError):
            self._count_publisher = await self._around.graph.advertise(
                CLIENT_COUNT, registry.message_type("std_msgs/Int32"), latch=True
            )
        self._publish_count()
        self._leaving = asyncio.ensure_future(self._end_with_node())

    async def wait_ended(self) -> None:
        """Wait until it listens no more: closed, or its node was shut down."""
        await self._ended.wait()

    async def close(self) -> None:
        """Hang up on all clients and listen no more. Idempotent."""
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        await self._close()

    async def _end_with_node(self) -> None:
        reason = await self._around.graph.wait_closed()
        self._tell(Level.WARN, f"rosbridge: its node was shut down ({reason}); it serves no more")
        await self._close()

    async def _close(self) -> None:
        for server in self._servers:
            server.close()
        for server in self._servers:
            await server.wait_closed()
        self._servers.clear()
        await self._around.close()
        await self._around.shared.close()
        if self._count_publisher is not None:
            await self._count_publisher.close()
            self._count_publisher = None
        self._ended.set()

    async def _listen(self, host: str, port: int) -> None:
        settings = self._settings
        encryption = server_encryption(settings.certificate, settings.key)
        try:
            async with system_bind_errors(host or None, port):
                server = await serve(
                    self._serve,
                    host,
                    port,
                    process_request=self._admit,
                    ssl=encryption,
                    compression="deflate" if settings.deflate else None,
                    max_size=settings.max_message_bytes,
                    max_queue=MAX_WAITING_FRAMES,
                    ping_interval=PING_INTERVAL_S,
                    ping_timeout=PING_LIMIT_S,
                    close_timeout=CLOSE_LIMIT_S,
                    server_header=None,
                    backlog=MAX_CLIENTS,
                    # A factory does as well as the class that the signature asks for.
                    create_connection=partial(DoorConnection, self._door),  # type: ignore[arg-type]
                )
        except OSError as error:
            raise _explain(host, port, error) from error
        self._servers.append(server)

    async def _admit(self, connection: ServerConnection, request: HttpRequest) -> Response | None:
        origin = single_header(request.headers, "Origin")
        host = single_header(request.headers, "Host") or ""
        authorization = single_header(request.headers, "Authorization") or ""
        if not self._admission.allows_origin(origin, host):
            if origin is not None:
                return self._refuse(
                    connection,
                    f"the page {origin!r:.200} is of another host; `--origin {origin:.200}` lets it in",
                )
            if not (self._admission.wants_token and self._admission.knows_token(request.path, authorization)):
                return self._refuse(connection, foreign_host(host))
        if not self._admission.allows_path(request.path):
            return self._refuse(
                connection, f"nothing is served at {request.path!r:.200}", HTTPStatus.NOT_FOUND
            )
        if len(self._clients) >= MAX_CLIENTS:
            return self._refuse(
                connection, f"at most {MAX_CLIENTS} clients may connect", HTTPStatus.SERVICE_UNAVAILABLE
            )
        return None

    def _refuse(
        self, connection: ServerConnection, reason: str, status: HTTPStatus = HTTPStatus.FORBIDDEN
    ) -> Response:
        self._door.report_refusal(connection.transport, reason)
        return connection.respond(status, f"rosbridge: {reason}\n")

    async def _serve(self, connection: ServerConnection) -> None:
        request = connection.request
        assert request is not None
        is_known = not self._admission.wants_token or self._admission.knows_token(
            request.path, single_header(request.headers, "Authorization") or ""
        )
        session = Session(connection, self._around, self._admission, peer_name(connection.transport))
        self._clients.add(session)
        self._changed(f"rosbridge: {session.name} connected")
        try:
            await session.run(is_known=is_known)
        except ConnectionClosed:
            pass
        finally:
            self._clients.discard(session)
            self._changed(f"rosbridge: {session.name} disconnected{_why(connection)}")

    def _changed(self, text: str) -> None:
        count = len(self._clients)
        self._tell(Level.INFO, f"{text} ({count} client{'' if count == 1 else 's'})")
        self._publish_count()

    def _publish_count(self) -> None:
        if self._count_publisher is not None:
            self._count_publisher.publish_raw([len(self._clients).to_bytes(4, "little")])


def _why(connection: ServerConnection) -> str:
    """Return what was wrong with a connection that we have ended."""
    sent = connection.protocol.close_sent
    if sent is None or sent.code in (1000, 1001, 1005):
        return ""
    return f": {sent.reason or sent.code}"


def _explain(host: str, port: int, error: OSError) -> TransportOpenError:
    if error.errno == errno.EADDRINUSE:
        return TransportOpenError(
            f"rosbridge: port {port} is already in use on {host}; stop the program that listens there "
            "(another rosbridge?), or choose another port"
        )
    if error.errno == errno.EADDRNOTAVAIL or isinstance(error, socket.gaierror):
        return TransportOpenError(
            f"rosbridge: {host} is no address of this machine; 0.0.0.0:{port} listens on all it has"
        )
    return TransportOpenError(f"rosbridge: cannot listen on {host}:{port}: {error.strerror}")
