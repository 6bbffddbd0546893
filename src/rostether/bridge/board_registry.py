"""Which boards there are: each name once, and a lost board's node kept for a while in case it comes back."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from rostether.bridge.board_node import BoardNode
from rostether.bridge.identity import numbered
from rostether.bridge.session import Session

# Leaving the graph must not hang on a master that does not answer.
NODE_CLOSE_LIMIT_S = 1.0
# A healthy board speaks every 2.5 s. A connection that was silent for longer, while the same host connects
# anew, belongs to a board that was switched off without a word.
HALF_OPEN_S = 3.0


@dataclass(slots=True, eq=False)
class Board:
    """One name that is taken: no node while it still joins, no session while the board is lost."""

    name: str
    base_name: str
    node: BoardNode | None = None
    session: Session | None = None
    farewell: asyncio.TimerHandle | None = None


class BoardRegistry:
    """The boards of one supervisor."""

    def __init__(self, grace_s: float, clock: Callable[[], float]) -> None:
        self._grace_s = grace_s
        self._clock = clock
        self._boards: dict[str, Board] = {}
        self._leaving: set[asyncio.Task[None]] = set()

    def __iter__(self) -> Iterator[Board]:
        return iter(self._boards.values())

    def claim(self, base_name: str, *, replaces_silent: bool = False) -> Board:
        """Return the board that a new connection is: a lost one that came back, else a new one.

        With `replaces_silent` a connection that has fallen silent gives way, since its peer has come anew.
        """
        number = 1
        while (board := self._boards.get(numbered(base_name, number))) is not None:
            if board.farewell is not None:
                board.farewell.cancel()
                board.farewell = None
                return board
            session = board.session
            if replaces_silent and session is not None and self._clock() - session.heard_at_s > HALF_OPEN_S:
                session.abandon()
                return board
            number += 1
        name = numbered(base_name, number)
        self._boards[name] = Board(name, base_name)
        return self._boards[name]

    def lose(self, board: Board, session: Session | None) -> None:
        """The board's connection ended: keep its node for the grace period."""
        if board.session is not session:
            return
        board.session = None
        if board.node is None or self._boards.get(board.name) is not board:
            self._boards.pop(board.name, None)
            return
        board.farewell = asyncio.get_running_loop().call_later(self._grace_s, self._leave, board)

    async def close(self) -> None:
        """Take every board out of the graph, in little more than a second."""
        for board in list(self._boards.values()):
            self._leave(board)
        if self._leaving:
            await asyncio.wait(list(self._leaving))

    def _leave(self, board: Board) -> None:
        if board.farewell is not None:
            board.farewell.cancel()
        if board.node is None:
            self._boards.pop(board.name, None)
            return
        task = asyncio.get_running_loop().create_task(self._close_node(board, board.node))
        self._leaving.add(task)
        task.add_done_callback(self._leaving.discard)

    async def _close_node(self, board: Board, node: BoardNode) -> None:
        # The name stays taken until the node is gone: a graph has no place for two of one name.
        board.farewell = None
        try:
            async with asyncio.timeout(NODE_CLOSE_LIMIT_S):
                await node.close()
        except TimeoutError:
            pass
        finally:
            self._boards.pop(board.name, None)
