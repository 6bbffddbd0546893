from __future__ import annotations

import asyncio
from typing import Any

import pytest

from rostether.bridge.board_registry import RECONNECT_S, Board, BoardRegistry
from rostether.errors import SessionError
from waiting import until


class FakeNode:
    """A node whose end the test controls."""

    def __init__(self) -> None:
        self.may_leave = asyncio.Event()
        self.may_leave.set()
        self.is_closed = False
        self.endpoints = self
        self.settled = 0

    def settle(self) -> None:
        self.settled += 1

    async def close(self) -> None:
        await self.may_leave.wait()
        self.is_closed = True


class FakeSession:
    def __init__(self, received_at_s: float = 0.0) -> None:
        self.received_at_s = received_at_s
        self.is_abandoned = False

    def abandon(self) -> None:
        self.is_abandoned = True


async def served(boards: BoardRegistry, name: str) -> tuple[Board, Any]:
    board = await boards.claim(name)
    node: Any = FakeNode()
    session: Any = FakeSession()
    board.node, board.session = node, session
    return board, node


async def test_a_lost_board_keeps_its_node_for_the_grace_period() -> None:
    boards = BoardRegistry(60.0, lambda: 0.0)
    board, node = await served(boards, "/arm")
    boards.handle_disconnect(board, board.session)
    assert await boards.claim("/arm") is board
    assert (board.node,) == (node,)
    assert list(boards) == [board]
    await boards.close()
    assert node.is_closed


async def test_each_node_that_has_left_is_reported() -> None:
    left: list[int] = []
    boards = BoardRegistry(0.0, lambda: 0.0, lambda: left.append(1))
    for name in ("/arm", "/leg", "/eye"):
        board, _ = await served(boards, name)
        boards.handle_disconnect(board, board.session)
    await until(lambda: len(left) == 3 and not list(boards), "the nodes to leave")
    await boards.close()


async def test_a_node_that_leaves_slowly_leaves_completely(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.bridge.board_registry.NODE_CLOSE_LIMIT_S", 0.0)
    boards = BoardRegistry(0.0, lambda: 0.0)
    board, node = await served(boards, "/arm")
    node.may_leave.clear()
    boards.handle_disconnect(board, board.session)
    await until(lambda: "/arm" not in boards._boards, "the name to be free")
    assert not node.is_closed
    node.may_leave.set()
    await until(lambda: node.is_closed, "the node to leave")
    await boards.close()


async def test_a_board_that_reconnects_before_its_disconnect_is_noticed_is_the_same() -> None:
    boards = BoardRegistry(60.0, lambda: 0.0)
    board, _ = await served(boards, "/arm")
    coming = asyncio.create_task(boards.claim("/arm"))
    await asyncio.sleep(0)
    boards.handle_disconnect(board, board.session)
    assert await coming is board
    await boards.close()


async def test_after_the_grace_period_the_name_is_free() -> None:
    boards = BoardRegistry(0.01, lambda: 0.0)
    board, node = await served(boards, "/arm")
    boards.handle_disconnect(board, board.session)
    await until(lambda: node.is_closed and not list(boards), "the node to leave")
    assert (await boards.claim("/arm")).node is None


async def test_a_kept_node_stays_without_its_board_and_without_its_topics() -> None:
    boards = BoardRegistry(0.01, lambda: 0.0)
    board, node = await served(boards, "/arm")
    board.is_kept = True
    boards.handle_disconnect(board, board.session)
    await until(lambda: node.settled == 1, "the topics to leave")
    assert not node.is_closed
    assert await boards.claim("/arm") is board
    assert (await boards.claim("/arm")).name == "/arm_2"


async def test_one_name_in_two_namespaces_is_two_names() -> None:
    boards = BoardRegistry(60.0, lambda: 0.0)
    left, right = await boards.claim("/left/arm"), await boards.claim("/right/arm")
    assert (left.name, right.name) == ("/left/arm", "/right/arm")
    assert (await boards.claim("/right/arm")).name == "/right/arm_2"


async def test_a_name_that_is_just_leaving_is_waited_for() -> None:
    boards = BoardRegistry(0.0, lambda: 0.0)
    board, node = await served(boards, "/arm")
    node.may_leave.clear()
    boards.handle_disconnect(board, board.session)
    await until(lambda: board.leaving is not None, "the node to begin to leave")
    claim = asyncio.ensure_future(boards.claim("/arm"))
    await asyncio.sleep(0)
    assert not claim.done()
    node.may_leave.set()
    fresh = await claim
    assert (fresh.name, fresh.node) == ("/arm", None)


async def test_a_board_that_never_joined_leaves_nothing() -> None:
    boards = BoardRegistry(60.0, lambda: 0.0)
    board = await boards.claim("/arm")
    boards.handle_disconnect(board, None)
    assert await boards.claim("/arm") is not board


async def test_a_connection_that_was_taken_over_ends_nothing() -> None:
    now = [0.0]
    boards = BoardRegistry(0.0, lambda: now[0])
    board, node = await served(boards, "/tcp_robot")
    old: Any = board.session
    old.received_at_s, now[0] = 1.5, 2.0
    other = asyncio.create_task(boards.claim("/tcp_robot", replaces_silent=True))
    await asyncio.sleep(2 * RECONNECT_S)
    assert not other.done()
    old.received_at_s = now[0] = 3.0
    assert (await other).name == "/tcp_robot_2"
    again = asyncio.create_task(boards.claim("/tcp_robot", replaces_silent=True))
    await asyncio.sleep(2 * RECONNECT_S)
    assert not again.done()
    now[0] = 10.0
    assert await again is board
    assert old.is_abandoned
    new: Any = FakeSession()
    board.session = new
    boards.handle_disconnect(board, old)
    assert board.session is new
    assert board.leave_timer is None
    assert not node.is_closed


async def test_a_node_that_was_shut_down_comes_with_the_next_connection() -> None:
    boards = BoardRegistry(60.0, lambda: 0.0)
    board, node = await served(boards, "/arm")
    node.may_leave.clear()
    boards.end(board)
    boards.handle_disconnect(board, board.session)
    claim = asyncio.ensure_future(boards.claim("/arm"))
    await asyncio.sleep(0)
    assert not claim.done()
    node.may_leave.set()
    fresh = await claim
    assert (fresh.name, fresh.node) == ("/arm", None)
    assert node.is_closed


async def test_a_name_that_another_node_took_is_not_served_again() -> None:
    boards = BoardRegistry(60.0, lambda: 0.0)
    board, node = await served(boards, "/arm")
    boards.dismiss(board)
    await until(lambda: node.is_closed, "the node to leave")
    with pytest.raises(SessionError, match="another node has the name /arm"):
        await boards.claim("/arm")


async def test_closing_waits_for_no_node_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.bridge.board_registry.NODE_CLOSE_LIMIT_S", 0.02)
    boards = BoardRegistry(60.0, lambda: 0.0)
    _, hanging = await served(boards, "/left")
    _, leaving = await served(boards, "/right")
    hanging.may_leave.clear()
    await boards.close()
    assert leaving.is_closed
    assert list(boards) == []
