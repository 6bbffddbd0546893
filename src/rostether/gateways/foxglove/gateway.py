"""Serves a live graph to Foxglove over its WebSocket protocol: topics, services, parameters and assets.

async with FoxgloveGateway(graph, store, FoxgloveSettings()) as gateway:
    print(gateway.url)

Payloads go to clients unchanged, with the definition of their publisher; a topic is subscribed on the graph
only while a client wants it. A client that reads slowly loses its own oldest messages, and does not slow
down other clients.
"""

from __future__ import annotations

import asyncio
import socket
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import Self

from msgspec import Struct

from rostether.errors import RostetherError
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.assets import Assets, FindPackages
from rostether.gateways.foxglove.channels import Channels
from rostether.gateways.foxglove.client import Client
from rostether.gateways.foxglove.connection_graph import ConnectionGraph
from rostether.gateways.foxglove.foxglove_context import FoxgloveContext
from rostether.gateways.foxglove.parameters import Parameters
from rostether.gateways.foxglove.recordings import RecordingControl, RecordingReports
from rostether.gateways.foxglove.server_messages import AdvertisedService, Channel, StatusLevel
from rostether.gateways.foxglove.services import FindServiceType, Services
from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.gateways.foxglove.sim_clock import SimClock
from rostether.gateways.shared_subscriptions import SharedSubscriptions
from rostether.gateways.teleop.teleop import Teleop
from rostether.gateways.websocket.access_rules import Rights
from rostether.gateways.websocket.connection import Connection
from rostether.gateways.websocket.server import WebSocketServer
from rostether.gateways.websocket.settings import ServedProtocol
from rostether.gateways.websocket.site import Site
from rostether.graph.ports import Graph, Level, Report
from rostether.mechanisms.block_end import BlockClosable
from rostether.mechanisms.tasks import cancel_all
from rostether.msgdef.search_waiting import definitions_searched
from rostether.serde.store import TypeStore
from rostether.transports.web_boards import WebBoards

_TIME_CAPABILITY = "time"
# View-only clients may still read parameters.
_CAPABILITIES_TO_ACT = ("clientPublish", "services")

# The id of the status "the graph cannot be read"; the page recognizes the status by it.
_GRAPH_STATUS_ID = "graph"

# The limit of warnings. Later clients receive all of them, and a user does not read a longer list.
_MAX_SHOWN_STATUSES = 50

# The delay after the graph could not be read.
_RETRY_S = 1.0

# Pages of Foxglove's web application may always connect.
_FOXGLOVE_SITE = "foxglove.dev"

# Boards on the serial ports of devices that show the page.
_SERIAL_PATH = "/serial"

# The WebSocket close code after which clients reconnect.
_SERVICE_RESTART = 1012


class DashboardParts(Struct, frozen=True):
    """The optional parts of a gateway.

    `site` has the files to serve. `join_teleop` makes the node of clients that drive. `recordings` records
    for clients. `boards` are boards on serial ports of the devices that show the page.
    """

    site: Site | None = None
    join_teleop: Callable[[], Awaitable[Graph]] | None = None
    recordings: RecordingControl | None = None
    boards: WebBoards | None = None

    def metadata(self, rights: Rights) -> dict[str, str]:
        """Return the metadata about the parts for a client with `rights`."""
        features = ["drive"] if self.join_teleop is not None and rights is Rights.FULL else []
        if self.recordings is not None:
            features.append("record")
        if self.boards is not None and rights is Rights.FULL:
            features.append("serial")
        return {"rights": rights.value, "features": ",".join(features)}


class FoxgloveGateway(BlockClosable):
    """One gateway on a graph; the caller closes the graph."""

    def __init__(
        self,
        graph: Graph,
        store: TypeStore,
        settings: FoxgloveSettings,
        *,
        find_service_type: FindServiceType | None = None,
        find_packages: FindPackages | None = None,
        report: Report | None = None,
        dashboard: DashboardParts | None = None,
    ) -> None:
        self._parts = parts = dashboard or DashboardParts()
        shared = SharedSubscriptions(graph, store)
        channels = Channels(
            store, shared, settings.topics, self._offer_channels, self._end_channels, self._warn_clients
        )
        self.context = FoxgloveContext(
            graph=graph,
            store=store,
            settings=settings,
            shared=shared,
            channels=channels,
            services=Services(
                graph, store, settings.services, find_service_type, self._offer_services, self._end_services
            ),
            parameters=Parameters(graph, settings.parameters),
            connections=ConnectionGraph(channels.known),
            assets=Assets(find_packages or dict, settings.limits.asset_bytes),
            clock=SimClock(
                graph, shared, lambda time_ns: self._broadcast(replies.time(time_ns)), self._restart_clients
            ),
            teleop=Teleop(parts.join_teleop) if parts.join_teleop is not None else None,
            recordings=RecordingReports(parts.recordings) if parts.recordings is not None else None,
        )
        self._report = report or (lambda level, text: None)
        self._server = WebSocketServer(
            ServedProtocol(settings.label, replies.SUBPROTOCOLS, viewer_site=_FOXGLOVE_SITE),
            settings,
            settings.limits,
            self._open_client,
            self._warn,
            site=parts.site,
            routes={_SERIAL_PATH: parts.boards.open if parts.boards is not None else None},
        )
        self._clients: dict[Client, None] = {}
        self._statuses: dict[str, str] = {}
        # Why the graph cannot be read now; empty if it can.
        self._problem = ""
        self._following: asyncio.Task[None] | None = None
        self._leaving: asyncio.Task[None] | None = None
        self._ended = asyncio.Event()
        self._session_id = str(time.time_ns())

    @property
    def port(self) -> int:
        """The port that it listens on; zero before the start."""
        return self._server.port

    @property
    def url(self) -> str:
        """The URL to enter in Foxglove."""
        return self._server.url(everywhere=socket.gethostname())

    async def start(self) -> None:
        """Listen, and follow the graph. Raises TransportOpenError, ConfigError."""
        await definitions_searched(self.context.store.registry)
        await self.context.clock.start()
        self._following = asyncio.ensure_future(self._follow())
        self._leaving = asyncio.ensure_future(self._end_with_node())
        try:
            await self._server.start()
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        """Close all connections, and end everything on the graph."""
        await cancel_all(*(task for task in (self._following, self._leaving) if task is not None))
        await self._server.close()
        await self.context.close()

    async def wait_ended(self) -> None:
        """Wait until the gateway's node has left the graph; after that, no client is served."""
        await self._ended.wait()

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    def add_client(self, connection: Connection, rights: Rights) -> Client:
        """Return a new client, after sending it the current state."""
        client = Client(self.context, connection, self._clients.pop, rights)
        self._clients[client] = None
        context, settings = self.context, self.context.settings
        withheld = () if rights is Rights.FULL else _CAPABILITIES_TO_ACT
        capabilities = [each for each in settings.capabilities if each not in withheld]
        if context.clock.is_simulated:
            capabilities.append(_TIME_CAPABILITY)
        send = client.sender.send
        send(
            replies.server_info(
                name=settings.name,
                capabilities=capabilities,
                # A client that reconnects can reuse its ids while the session id is the same.
                session_id=self._session_id,
                metadata={
                    "ROS_DISTRO": "noetic",
                    "node": context.graph.node_name,
                    **self._parts.metadata(rights),
                    **settings.metadata,
                },
            )
        )
        # The protocol requires this message in each connection, even with an empty list.
        send(replies.advertise(context.channels.by_id.values()))
        if context.services.by_id and "services" in capabilities:
            send(replies.advertise_services(context.services.by_id.values()))
        for text in self._statuses.values():
            send(text)
        if self._problem:
            send(self._problem_status())
        return client

    # Internal methods.

    def _warn(self, text: str) -> None:
        self._report(Level.WARN, f"{self.context.settings.label}: {text}")

    def _open_client(self, connection: Connection) -> Client:
        rights = self._server.access.rights(connection.path, connection.headers)
        return self.add_client(connection, rights or Rights.VIEW)

    async def _follow(self) -> None:
        context = self.context
        while True:
            try:
                async for snapshot in context.graph.changes():
                    self._show_problem(snapshot.problem)
                    context.channels.update(snapshot)
                    context.services.update(snapshot)
                    if (changes := context.connections.update(snapshot)) is not None:
                        message = replies.connection_graph_update(changes)
                        for client in self._clients:
                            if client.wants_connection_graph:
                                client.sender.send(message)
            except RostetherError as error:
                self._warn(f"the graph cannot be read: {error}")
            await asyncio.sleep(_RETRY_S)

    def _show_problem(self, problem: str) -> None:
        """Show clients why the graph cannot be read; an empty `problem` removes the line."""
        if problem == self._problem:
            return
        self._problem = problem
        self._broadcast(self._problem_status() if problem else replies.remove_status([_GRAPH_STATUS_ID]))

    def _problem_status(self) -> str:
        return replies.status(StatusLevel.WARNING, self._problem, _GRAPH_STATUS_ID)

    async def _end_with_node(self) -> None:
        reason = await self.context.graph.wait_closed()
        self._warn(f"its node was shut down ({reason}); start it again")
        if self._following is not None:
            self._following.cancel()
        await self._server.close()
        self._ended.set()

    def _broadcast(self, message: str | bytes) -> None:
        for client in list(self._clients):
            client.sender.send(message)

    def _offer_channels(self, channels: Sequence[Channel]) -> None:
        if self._clients:
            self._broadcast(replies.advertise(channels))

    def _end_channels(self, channels: Sequence[Channel]) -> None:
        for client in list(self._clients):
            for channel in channels:
                client.channel_ended(channel)
        self._broadcast(replies.unadvertise(channel.id for channel in channels))

    def _offer_services(self, services: Sequence[AdvertisedService]) -> None:
        if self._clients and "services" in self.context.settings.capabilities:
            self._broadcast(replies.advertise_services(services))

    def _end_services(self, services: Sequence[AdvertisedService]) -> None:
        if self._clients and "services" in self.context.settings.capabilities:
            self._broadcast(replies.unadvertise_services(service.id for service in services))

    def _warn_clients(self, text: str) -> None:
        if text in self._statuses or len(self._statuses) >= _MAX_SHOWN_STATUSES:
            return
        self._warn(text)
        message = self._statuses[text] = replies.status(
            StatusLevel.WARNING, text, f"warning-{len(self._statuses)}"
        )
        self._broadcast(message)

    def _restart_clients(self) -> None:
        # A client learns only at the start of its connection whether the clock is simulated.
        self._session_id = str(time.time_ns())
        for client in list(self._clients):
            client.sender.close(_SERVICE_RESTART, "the clock has changed")
