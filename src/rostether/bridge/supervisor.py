"""Serves every link address: opens or listens, opens again after a loss, and closes everything in order.

address ── open, or listen ──> transport ── identity ──> board (joins the graph) ──> session ──┐
   ^                                                                                          │
   └──────────── wait, then open again <── the board's node stays for the grace period <──────┘
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from typing import Protocol

from msgspec import Struct

from rostether.bridge.board_node import BoardNode
from rostether.bridge.board_registry import Board, BoardRegistry
from rostether.bridge.health.diagnostics import BoardView, view_board
from rostether.bridge.health.health_round import HealthRound
from rostether.bridge.identity import hardware_id, identify_peer, node_name
from rostether.bridge.peer_entry import BOARD_ENTRY
from rostether.bridge.ports.discovery import Discovery
from rostether.bridge.ports.found_port import THIS_MACHINE, MachinePorts
from rostether.bridge.ports.link_keeper import (
    LinkKeeper,
    OpenAttempts,
    OpenTransport,
    identify_address,
    return_condition,
)
from rostether.bridge.process_memory import BoardObjects
from rostether.bridge.reporter import LimitedReporter, Reporter, SilentReporter, reason_of
from rostether.bridge.session import Session
from rostether.bridge.settings import DEFAULT_NODES, DEFAULT_SETTINGS, BoardNodes, BridgeSettings
from rostether.errors import NodeEndedError, RostetherError, SessionError, TransportError, TransportOpenError
from rostether.graph.ports import NAME_TAKEN, JoinGraph, Level
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.loopback import is_loopback
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.mechanisms.waiting import wait_for_master
from rostether.names.graph_name import join as join_names
from rostether.names.graph_name import validate_name
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.device_book import DeviceBook
from rostether.ports.known_boards import KnownBoards
from rostether.ports.settings import DeviceSettings
from rostether.serde.store import TypeStore
from rostether.transports.address import Address, SerialAddress, TcpAddress, WebAddress, XbeeAddress
from rostether.transports.opening import listen, open_transport
from rostether.transports.peers import PeerEntry, PeerTransport
from rostether.transports.transport import Listener, Transport
from rostether.transports.web import WebTransport

# The longest pause between attempts to reach a master or a radio; boards are expected soon after its start.
MAX_JOIN_WAIT_S = 2.0
# A board sends data within 2 s after it connects; a silent connection uses a session that another board
# may need.
FIRST_FRAME_LIMIT_S = 60.0
# The time to ask the boards to stop; a hung board does not read the request.
STOP_LIMIT_S = 0.8


class Listen(Protocol):
    """Listens for links; `transports.opening.listen` is the real one."""

    def __call__(
        self, address: Address, on_transport: Callable[[Transport], None], *, entry: PeerEntry | None = None
    ) -> Awaitable[Listener]:
        """Listen, and call `on_transport` with each connection. Raises TransportOpenError."""


class Links(Struct, frozen=True):
    """How links are opened; `tap` may wrap each of them to record it."""

    open_transport: OpenTransport = open_transport
    listen: Listen = listen
    tap: Callable[[Transport], Transport] | None = None


DEFAULT_LINKS = Links()


class Supervisor:
    """Serves boards at many addresses at once; each board is a separate node, created by `join`.

    `devices` has the settings of individual boards.
    """

    def __init__(
        self,
        join: JoinGraph,
        store: TypeStore,
        *,
        reporter: Reporter | None = None,
        settings: BridgeSettings = DEFAULT_SETTINGS,
        nodes: BoardNodes = DEFAULT_NODES,
        devices: DeviceBook | None = None,
        links: Links = DEFAULT_LINKS,
    ) -> None:
        self._join = join
        self._store = store
        self._reporter = reporter if reporter is not None else SilentReporter()
        self._settings = settings
        self._nodes = nodes
        self._devices = devices if devices is not None else DeviceBook()
        self._links = links
        self._clock = asyncio.get_running_loop().time
        # For lines that any device can cause by connecting repeatedly.
        self._limited_reporter = LimitedReporter(self._reporter, self._clock)
        self._objects = BoardObjects()
        self._boards = BoardRegistry(settings.grace_s, self._clock, self._objects.node_left)
        self._health = HealthRound(
            lambda: self._boards, store, self._reporter, self._clock, publishes=nodes.diagnostics
        )
        self._listeners: list[Listener] = []
        self._tasks: set[asyncio.Task[None]] = set()
        self._is_closing = False
        self._has_failed = False
        self._done = asyncio.Event()

    @property
    def listening_on(self) -> list[str]:
        """Where boards can connect, with the ports that were bound."""
        return [listener.address for listener in self._listeners]

    @property
    def has_failed(self) -> bool:
        """Whether an error ended a link, which is not opened again."""
        return self._has_failed

    def boards(self) -> list[BoardView]:
        """Return the state of each board, sorted by name."""
        views = [view_board(board.node, board.session) for board in self._boards if board.node is not None]
        return sorted(views, key=lambda view: view.node)

    async def wait_for_subscribers(self) -> None:
        """Wait until each topic of a board that nodes subscribe to has a connected subscriber."""
        for board in self._boards:
            if board.node is not None:
                await board.node.wait_for_subscribers()

    async def start(self, addresses: Sequence[Address]) -> None:
        """Start to serve. Missing links are opened when they appear.

        With `BoardNodes.keeps_node`, the node of the first address joins the graph first.

        Raises TransportOpenError for an address that cannot be listened on, InvalidNameError for a name= or
        ns= that is not a ROS name.
        """
        for address in addresses:
            for name in (address.name, address.ns):
                if name is not None:
                    validate_name(name)
        self._health.start()
        if self._nodes.keeps_node:
            await self._join_early(addresses[0])
        for address in addresses:
            if address.listens:
                await self._start_listening(address)
            else:
                keeper = LinkKeeper(
                    address, self._links.open_transport, self._serve, self._reporter, self._devices
                )
                self._run(keeper.run())

    def discover(
        self, known: KnownBoards, *, ports: MachinePorts = THIS_MACHINE, excluded: Sequence[Address] = ()
    ) -> None:
        """Serve the boards on this machine's serial ports as they appear, except the ports `excluded`."""
        discovery = Discovery(
            devices=self._devices,
            known=known,
            serve=self._serve,
            spawn=self._run,
            reporter=self._reporter,
            excluded=[
                address.path for address in excluded if isinstance(address, SerialAddress | XbeeAddress)
            ],
            ports=ports,
        )
        self._run(discovery.run())

    async def wait_done(self) -> None:
        """Wait until no board is served: after `close`, or when other nodes have shut down all boards' nodes.

        If an address listens, other nodes can end the wait only by shutting down the kept node.
        """
        await self._done.wait()

    async def close(self) -> None:
        """Ask every board to stop, and leave the graph, within two seconds. Idempotent."""
        self._is_closing = True
        await self._health.close()
        stops = [
            asyncio.ensure_future(board.session.stop()) for board in self._boards if board.session is not None
        ]
        if stops:
            _, late = await asyncio.wait(stops, timeout=STOP_LIMIT_S)
            for stop in late:
                stop.cancel()
        await cancel_all(*self._tasks)
        await asyncio.gather(self._boards.close(), *(listener.close() for listener in self._listeners))
        self._objects.close()
        self._done.set()

    async def _start_listening(self, address: Address) -> None:
        def on_transport(transport: Transport) -> None:
            if self._is_closing:
                transport.close()
                return
            self._run(self._serve_peer(address, transport))

        try:
            await self._listen(address, on_transport)
        except TransportOpenError as error:
            if not isinstance(address, XbeeAddress):
                raise
            self._run(self._wait_for_radio(address, on_transport, str(error)))

    async def _wait_for_radio(
        self, address: XbeeAddress, on_transport: Callable[[Transport], None], reason: str
    ) -> None:
        attempts = OpenAttempts(
            Backoff(limit_s=MAX_JOIN_WAIT_S),
            lambda reason: self._reporter.report(Level.ERROR, f"{reason} (trying again)"),
            settle_s=0.0,
        )
        while True:
            await attempts.wait_after(reason)
            try:
                return await self._listen(address, on_transport)
            except TransportOpenError as error:
                reason = str(error)

    async def _listen(self, address: Address, on_transport: Callable[[Transport], None]) -> None:
        listener = await self._links.listen(address, on_transport, entry=BOARD_ENTRY)
        self._listeners.append(listener)
        if isinstance(address, WebAddress):
            # The dashboard reports where its page is.
            return
        self._reporter.report(Level.INFO, f"Waiting for boards on {listener.address}")

    async def _serve_peer(self, address: Address, transport: Transport) -> None:
        self._limited_reporter.report(Level.INFO, f"Connection from {transport.peer}")
        if isinstance(transport, WebTransport):
            address = transport.address
        error = await self._serve(address, transport, identify_peer(transport.remote, transport.proof))
        self._limited_reporter.report(
            Level.INFO, str(error) if error is not None else f"{transport.peer} is closed"
        )

    async def _serve(
        self, address: Address, transport: Transport, identity: BoardIdentity
    ) -> TransportError | None:
        """Serve one connection until it ends; return the error. Raises SessionError, InvalidNameError."""
        device = self._devices.settings_for(address.name, identity)
        name = node_name(address, transport.peer, identity, device)
        is_program = transport.remote is not None and is_loopback(transport.remote)
        is_remote = transport.remote is not None and not is_program
        try:
            board = await self._boards.claim(name, replaces_silent=is_remote and address.listens)
        except SessionError:
            transport.close()
            raise
        session: Session | None = None
        timer: asyncio.TimerHandle | None = None
        try:
            node = board.node or await self._create_node(address, board, device)
            node.hardware_id = hardware_id(address, transport.peer, identity)
            node.health.radio = transport.quality if isinstance(transport, PeerTransport) else None
            node.program = address.program if isinstance(address, SerialAddress) else None
            baud = address.baud if isinstance(address, SerialAddress | XbeeAddress | WebAddress) else None
            if self._links.tap is not None:
                transport = self._links.tap(transport)
            session = board.session = Session(transport, node, baud=baud)
            if isinstance(address, SerialAddress) and address.pauses is not None:
                address.pauses.on_pause = session.note_pause
            session.start()
            self._objects.connected()
            if isinstance(address, TcpAddress) and address.listens:
                timer = asyncio.get_running_loop().call_later(
                    FIRST_FRAME_LIMIT_S, _end_without_frame, session
                )
            try:
                error = await session.wait_ended()
            finally:
                self._objects.disconnected()
            node.health.disconnected(error, is_program=is_program)
            if board.leaving is not None:
                ended = SessionError if board.is_dismissed else NodeEndedError
                raise ended(f"node {board.name} was shut down by another node")
            return error
        finally:
            if timer is not None:
                timer.cancel()
            transport.close()
            self._boards.handle_disconnect(
                board, session, is_stranger=address.listens and _is_stranger(session)
            )

    async def _watch(self, address: Address, board: Board, node: BoardNode) -> None:
        """End a board whose node the graph shuts down."""
        reason = await node.graph.wait_closed()
        if board.leaving is not None or self._is_closing:
            return
        session = board.session
        if board.is_kept or NAME_TAKEN in reason:
            self._boards.dismiss(board)
            condition = "you restart rostether"
        else:
            self._boards.end(board)
            condition = return_condition(address)
        text = f"{reason}; its board is not served until {condition}"
        self._reporter.report(Level.ERROR, text, node=node.graph.node_name)
        if session is not None:
            await session.stop()
        if board.is_kept:
            self._done.set()

    async def _join_early(self, address: Address) -> None:
        identity = identify_address(address)
        device = self._devices.settings_for(address.name, identity)
        board = await self._boards.claim(node_name(address, "", identity, device))
        board.is_kept = True
        try:
            await self._create_node(address, board, device)
        finally:
            self._boards.handle_disconnect(board, None)

    async def _create_node(self, address: Address, board: Board, device: DeviceSettings) -> BoardNode:
        """Join the graph for a board, and stop serving it when the graph shuts down its node."""
        given = address.ns or device.namespace
        namespace = join_names("/", given or (board.name if self._nodes.ns_per_board else "/"))
        remappings = {**self._nodes.remappings, **device.remap}
        graph = await wait_for_master(
            lambda: self._join(board.name, namespace=namespace, remappings=remappings),
            lambda error: self._reporter.report(Level.WARN, f"{error}; waiting for it", node=board.name),
            max_retry_s=MAX_JOIN_WAIT_S,
        )
        node = board.node = BoardNode(graph, self._store, self._reporter, self._clock, self._settings, device)
        board.grace_s = device.grace_s
        self._run(self._watch(address, board, node))
        return node

    def _run(self, work: Awaitable[object]) -> asyncio.Task[None]:
        task = start_task(self._tasks, self._guard(work))
        task.add_done_callback(self._ended)
        return task

    def _ended(self, _task: asyncio.Task[None]) -> None:
        if not self._tasks and not self._listeners:
            self._done.set()

    async def _guard(self, work: Awaitable[object]) -> None:
        try:
            await work
        except SessionError:
            # Another program shut down the board's node; `_watch` has reported it.
            return
        except RostetherError as error:
            self._has_failed = True
            self._limited_reporter.report(Level.ERROR, str(error))
        except Exception as error:  # noqa: BLE001 - one link's failure stays with that link
            self._has_failed = True
            self._limited_reporter.report(Level.ERROR, f"a link failed: {reason_of(error)}")


def _end_without_frame(session: Session) -> None:
    if not session.link.statistics.frames_received:
        session.transport.close()


def _is_stranger(session: Session | None) -> bool:
    """Return whether the peer never sent a frame: a port scanner must not leave nodes behind."""
    return session is not None and session.link.version is None and not any(session.node.endpoints)
