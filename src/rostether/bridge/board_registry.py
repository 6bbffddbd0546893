"""The boards of a bridge: each node name once; a lost board's node is kept for a while."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator

from msgspec import Struct

from rostether.bridge.board_node import BoardNode
from rostether.bridge.identity import numbered
from rostether.bridge.reporter import reason_of
from rostether.bridge.session import Session
from rostether.errors import SessionError
from rostether.graph.ports import Level
from rostether.mechanisms.tasks import start_task

# Leaving the graph must not hang on a master that does not answer.
NODE_CLOSE_LIMIT_S = 0.8
# A healthy board sends something every 2.5 s. A connection that was silent for longer, while the same host
# opens a new connection, belongs to a board that was switched off.
HALF_OPEN_S = 3.0
# A board that disconnects and reconnects immediately is the same one: both events may arrive together.
RECONNECT_S = 0.02


class Board(Struct, eq=False):
    """One node name in use. `node` is None while the node joins, `session` is None while the board is lost.

    A node that `is_kept` stays in the graph without its board, before the board connects and after it is
    lost. `grace_s` replaces the registry's grace period, unless it is None. If `is_dismissed`, boards of
    this name are refused.
    """

    name: str
    node: BoardNode | None = None
    session: Session | None = None
    is_lost: bool = False
    is_kept: bool = False
    is_dismissed: bool = False
    grace_s: float | None = None
    leave_timer: asyncio.TimerHandle | None = None
    leaving: asyncio.Task[None] | None = None


class BoardRegistry:
    """The boards of one supervisor; `on_left` is called when a board's node has left the graph."""

    def __init__(
        self, grace_s: float, clock: Callable[[], float], on_left: Callable[[], None] = lambda: None
    ) -> None:
        self._grace_s = grace_s
        self._clock = clock
        self._boards: dict[str, Board] = {}
        self._dismissed: set[str] = set()
        self._on_left = on_left
        self._closing: set[asyncio.Task[None]] = set()

    def __iter__(self) -> Iterator[Board]:
        """Yield the boards that have a node now, connected or not."""
        return iter([board for board in self._boards.values() if board.node is not None])

    async def claim(self, node_name: str, *, replaces_silent: bool = False) -> Board:
        """Return the board of a new connection: a lost board that reconnected, else a new one.

        `node_name` is the full name; a number is appended if another board has it. With `replaces_silent`,
        the new connection replaces a silent one of the same peer. For this, the method waits until the old
        connection has received data, or was silent for HALF_OPEN_S. Raises SessionError for a name that was
        dismissed.
        """
        number = 1
        has_waited = False
        claimed_s = self._clock()
        while True:
            name = numbered(node_name, number)
            if name in self._dismissed:
                raise SessionError(f"another node has the name {name}; restart rostether to serve this board")
            board = self._boards.get(name)
            if board is None:
                board = self._boards[name] = Board(name)
                return board
            if board.leaving is not None:
                # A graph cannot have two nodes of one name.
                await asyncio.wait([board.leaving])
                continue
            if board.is_lost:
                board.is_lost = False
                self._cancel_leave_timer(board)
                return board
            session = board.session
            may_be_gone = replaces_silent and session is not None and session.received_at_s <= claimed_s
            if session is not None and may_be_gone and self._clock() - session.received_at_s > HALF_OPEN_S:
                session.abandon()
                return board
            if may_be_gone or not has_waited:
                has_waited = True
                await asyncio.sleep(RECONNECT_S)
                continue
            number += 1

    def handle_disconnect(self, board: Board, session: Session | None, *, is_stranger: bool = False) -> None:
        """Keep the node of a disconnected board for the grace period, or permanently if it `is_kept`.

        The node of a peer that is not a board (`is_stranger`) leaves immediately.
        """
        if board.session is not session or board.leaving is not None:
            return
        board.session = None
        if board.node is None:
            self._boards.pop(board.name, None)
        elif self._boards.get(board.name) is board:
            board.is_lost = True
            grace_s = self._grace_s if board.grace_s is None else board.grace_s
            if is_stranger and not board.is_kept:
                grace_s = 0.0
            board.leave_timer = asyncio.get_running_loop().call_later(grace_s, self._end_grace, board)

    def end(self, board: Board) -> None:
        """Remove a board immediately, for example because its node was shut down; it may reconnect later."""
        self._cancel_leave_timer(board)
        if board.node is None:
            self._boards.pop(board.name, None)
        elif board.leaving is None:
            board.leaving = asyncio.get_running_loop().create_task(self._close_node(board, board.node))

    def dismiss(self, board: Board) -> None:
        """Remove a board whose name another node now uses: the two nodes would replace each other forever."""
        board.is_dismissed = True
        self._dismissed.add(board.name)
        self.end(board)

    async def close(self) -> None:
        """Remove every board from the graph, in less than a second."""
        for board in list(self._boards.values()):
            self.end(board)
        leaving = [board.leaving for board in self._boards.values() if board.leaving is not None]
        if leaving:
            await asyncio.wait(leaving)
        for closing in self._closing:
            closing.cancel()

    def _end_grace(self, board: Board) -> None:
        if board.is_kept and board.node is not None:
            # Nothing is attached: all endpoints of the board leave the graph.
            board.node.endpoints.settle()
        else:
            self.end(board)

    def _cancel_leave_timer(self, board: Board) -> None:
        if board.leave_timer is not None:
            board.leave_timer.cancel()
            board.leave_timer = None

    async def _close_node(self, board: Board, node: BoardNode) -> None:
        closing = start_task(self._closing, self._close_and_report(node))
        closing.add_done_callback(lambda _closing: self._on_left())
        await asyncio.wait([closing], timeout=NODE_CLOSE_LIMIT_S)
        # From now on, the name is free, even if the master did not answer and the node is still leaving.
        self._boards.pop(board.name, None)

    async def _close_and_report(self, node: BoardNode) -> None:
        try:
            await node.close()
        except Exception as error:  # noqa: BLE001 - whatever a graph raises, the other boards continue
            node.notices.report(Level.WARN, f"the node may still be listed: {reason_of(error)}")
