"""Checks every board once a second: reports problems, and publishes /diagnostics.

The node of each board publishes the board's status, as in the established host. So no further node joins the
graph. Without a subscriber, no message is made.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from weakref import WeakKeyDictionary

from rostether.bridge.board_node import BoardNode
from rostether.bridge.board_registry import Board
from rostether.bridge.health.board_status import TOPIC, TYPE
from rostether.bridge.health.diagnostics import view_board
from rostether.bridge.health.diagnostics_message import StatusWriter
from rostether.bridge.health.shared_topics import SharedTopics
from rostether.bridge.reporter import Reporter, reason_of
from rostether.errors import GraphError
from rostether.graph.ports import Level, Publisher
from rostether.mechanisms.tasks import cancel_all
from rostether.serde.store import TypeStore

# The interval that diagnostic tools expect.
PERIOD_S = 1.0

# A new subscriber gets its first message within this time.
NEW_SUBSCRIBER_PERIOD_S = 0.2

# Boards checked in one turn, in 1 or 2 ms: a hundred in one turn would delay all messages.
TURN_BOARDS = 4


class HealthRound:
    """Checks the boards of one supervisor; `publishes` enables /diagnostics."""

    def __init__(
        self,
        boards: Callable[[], Iterable[Board]],
        store: TypeStore,
        reporter: Reporter,
        clock: Callable[[], float],
        *,
        publishes: bool,
    ) -> None:
        self._boards = boards
        self._store = store
        self._reporter = reporter
        self._clock = clock
        self._publishes = publishes
        self._publishers: WeakKeyDictionary[BoardNode, _StatusPublisher] = WeakKeyDictionary()
        self._tasks: list[asyncio.Task[None]] = []
        self._is_broken = False
        self._shared_topics = SharedTopics(reporter)

    def start(self) -> None:
        """Start the checks, and the publications if they are enabled."""
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._run())]
        if self._publishes:
            self._tasks.append(loop.create_task(self._serve_new_subscribers()))

    async def close(self) -> None:
        """Stop, and unadvertise. Idempotent."""
        await cancel_all(*self._tasks)
        for publisher in list(self._publishers.values()):
            await publisher.close()

    def _check_boards(self, boards: Iterable[Board]) -> None:
        now_s = self._clock()
        for board in boards:
            if board.node is None or board.leaving is not None:
                continue
            try:
                self._check_board(board, board.node, now_s)
            except Exception as error:  # noqa: BLE001 - diagnostics must not end the bridge
                self._report_defect(error)

    async def _run(self) -> None:
        while True:
            boards = list(self._boards())
            starts = range(0, len(boards), TURN_BOARDS) or range(1)
            for start in starts:
                await asyncio.sleep(PERIOD_S / len(starts))
                self._check_boards(boards[start : start + TURN_BOARDS])
            self._shared_topics.check(boards)

    async def _serve_new_subscribers(self) -> None:
        while True:
            await asyncio.sleep(NEW_SUBSCRIBER_PERIOD_S)
            self._check_boards(board for board in list(self._boards()) if self._has_new_subscriber(board))

    def _has_new_subscriber(self, board: Board) -> bool:
        publisher = self._publishers.get(board.node) if board.node is not None else None
        return publisher is not None and publisher.has_new_subscriber()

    def _check_board(self, board: Board, node: BoardNode, now_s: float) -> None:
        session = board.session
        is_connected = session is not None and session.is_connected
        findings = node.health.find(now_s) if is_connected else []
        node.health.report(findings, now_s)
        if not self._publishes:
            return
        publisher = self._publishers.get(node)
        if publisher is None:
            publisher = self._publishers[node] = _StatusPublisher(node, self._store)
        if publisher.is_wanted:
            publisher.publish(publisher.writer.array(node, view_board(node, session), findings, now_s))

    def _report_defect(self, error: Exception) -> None:
        if not self._is_broken:
            self._is_broken = True
            self._reporter.report(Level.ERROR, f"diagnostics failed: {reason_of(error)}")


class _StatusPublisher:
    """One board's publisher of /diagnostics, advertised in the background."""

    def __init__(self, node: BoardNode, store: TypeStore) -> None:
        self.writer = StatusWriter()
        self._store = store
        self._publisher: Publisher | None = None
        self._known_subscribers = 0
        self._opening = asyncio.get_running_loop().create_task(self._open(node))

    @property
    def is_wanted(self) -> bool:
        """Whether there is a subscriber."""
        return self._publisher is not None and self._publisher.subscriber_count > 0

    def has_new_subscriber(self) -> bool:
        """Return whether a subscriber came since the last call."""
        before = self._known_subscribers
        self._known_subscribers = self._publisher.subscriber_count if self._publisher is not None else 0
        return self._known_subscribers > before

    def publish(self, fields: dict[str, object]) -> None:
        """Publish one message."""
        if self._publisher is not None:
            self._publisher.publish_raw([self._store.codec(TYPE).encode(fields)])

    async def close(self) -> None:
        """Stop advertising if that is still running; the graph removes the rest with the node."""
        await cancel_all(self._opening)

    async def _open(self, node: BoardNode) -> None:
        try:
            self._publisher = await node.graph.advertise(TOPIC, self._store.registry.message_type(TYPE))
        except GraphError as error:
            node.notices.report(Level.WARN, f"{TOPIC} is not published: {error}")
        except Exception as error:  # noqa: BLE001 - diagnostics must not end the bridge
            node.notices.report(Level.ERROR, f"{TOPIC} is not published: {reason_of(error)}")
