"""The rosbridge server: the v2 protocol of rosbridge over WebSockets, on the graph port.

Like rosbridge_suite, it serves web pages with roslibjs and programs with roslibpy. By default it listens
on loopback only.
"""

from __future__ import annotations

import asyncio
import contextlib

from rostether.errors import RostetherError
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.message_forms import MessageForms
from rostether.gateways.rosbridge.offered_services import OfferedServices
from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi
from rostether.gateways.rosbridge.rosbridge_context import RosbridgeContext
from rostether.gateways.rosbridge.service_types import AskServer, ServiceTypes
from rostether.gateways.rosbridge.session import Session
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.gateways.shared_subscriptions import SharedSubscriptions
from rostether.gateways.websocket.access_rules import Rights
from rostether.gateways.websocket.connection import Connection
from rostether.gateways.websocket.server import WebSocketServer
from rostether.gateways.websocket.settings import ServedProtocol
from rostether.gateways.websocket.websocket_stream import WebSocketStream
from rostether.graph.callbacks import report_error
from rostether.graph.ports import Graph, Level, Publisher, Report
from rostether.mechanisms.rate_limits import LineBudget
from rostether.mechanisms.text import counted
from rostether.msgdef.search_waiting import definitions_searched
from rostether.serde.store import TypeStore

# The topic on which rosbridge publishes the number of its clients.
_CLIENT_COUNT = "client_count"


class RosbridgeServer:
    """A rosbridge server on one node of a graph; the caller closes the node."""

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        settings: RosbridgeSettings | None = None,
        *,
        style: Style = Style.ROS1,
        ask_service_type: AskServer | None = None,
        local_services: Rosapi | None = None,
        report: Report = lambda level, text: None,
    ) -> None:
        settings = settings or RosbridgeSettings()
        self._report = report
        self._context = RosbridgeContext(
            graph,
            store,
            settings,
            shared=SharedSubscriptions(graph, store),
            forms=MessageForms(store, style, graph.now),
            service_types=ServiceTypes(graph, store, ask_service_type),
            offered=OfferedServices(graph),
            local_services=local_services,
            warn=self._warn,
        )
        # Any peer can cause these lines by connecting repeatedly.
        self._client_lines = LineBudget()
        self._clients: dict[Session, asyncio.Task[None]] = {}
        self._count_publisher: Publisher | None = None
        self._leaving: asyncio.Task[None] | None = None
        self._ended = asyncio.Event()
        self._server = WebSocketServer(
            # Clients may also send the token in their first message.
            ServedProtocol(
                "rosbridge", path=settings.path, deflates=settings.deflate, wants_token_first=False
            ),
            settings,
            settings.limits,
            self._open_session,
            self._warn,
        )

    @property
    def port(self) -> int:
        """The port that it listens on; zero before the start."""
        return self._server.port

    @property
    def uri(self) -> str:
        """The URL for clients on this machine."""
        return self._server.url()

    async def start(self) -> None:
        """Listen. Raises TransportOpenError, ConfigError."""
        await definitions_searched(self._context.store.registry)
        await self._server.start()
        registry = self._context.store.registry
        with contextlib.suppress(RostetherError):
            self._count_publisher = await self._context.graph.advertise(
                _CLIENT_COUNT, registry.message_type("std_msgs/Int32"), latch=True
            )
        self._publish_count()
        self._leaving = asyncio.ensure_future(self._end_with_node())

    async def wait_ended(self) -> None:
        """Wait until it stops listening: it was closed, or its node was shut down."""
        await self._ended.wait()

    async def close(self) -> None:
        """Close all connections and stop listening. Idempotent."""
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        await self._close()

    async def _end_with_node(self) -> None:
        reason = await self._context.graph.wait_closed()
        self._warn(f"its node was shut down ({reason}); start it again")
        await self._close()

    def _warn(self, text: str) -> None:
        self._report(Level.WARN, f"rosbridge: {text}")

    async def _close(self) -> None:
        await self._server.close()
        if self._clients:
            await asyncio.wait(list(self._clients.values()))
        await self._context.close()
        await self._context.shared.close()
        if self._count_publisher is not None:
            await self._count_publisher.close()
            self._count_publisher = None
        self._ended.set()

    def _open_session(self, connection: Connection) -> WebSocketStream:
        stream = WebSocketStream(connection)
        session = Session(stream, self._context, connection.peer)
        rights = self._server.access.rights(connection.path, connection.headers)
        self._clients[session] = asyncio.ensure_future(
            self._serve(session, connection, is_authenticated=rights is Rights.FULL)
        )
        self._changed(f"rosbridge: {session.name} connected")
        return stream

    async def _serve(self, session: Session, connection: Connection, *, is_authenticated: bool) -> None:
        try:
            await session.run(is_authenticated=is_authenticated)
        except Exception as error:  # noqa: BLE001 - one client's failure must not affect others
            report_error(f"rosbridge client {session.name}", error)
        finally:
            connection.close()
            del self._clients[session]
            why = f": {connection.fault}" if connection.fault else ""
            self._changed(f"rosbridge: {session.name} disconnected{why}")

    def _changed(self, text: str) -> None:
        self._publish_count()
        omitted_count = self._client_lines.admit(asyncio.get_running_loop().time())
        if omitted_count is None:
            return
        if omitted_count:
            self._warn(f"omitted {counted(omitted_count, 'line')} like the next one")
        self._report(Level.INFO, f"{text} ({counted(len(self._clients), 'client')})")

    def _publish_count(self) -> None:
        if self._count_publisher is not None:
            self._count_publisher.publish_raw([len(self._clients).to_bytes(4, "little")])
