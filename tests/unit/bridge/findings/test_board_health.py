from __future__ import annotations

import asyncio

import pytest

from rostether.bridge.board_node import BoardNode
from rostether.bridge.findings.finding import Code
from rostether.bridge.findings.resets import MIN_RESETS
from rostether.errors import PeerClosedError, TransportClosedError, TransportError
from rostether.rosserial.events import ProtocolDetected
from rostether.rosserial.link_statistics import LinkStatistics
from unit.bridge.nodes import STORE, World


@pytest.mark.parametrize(
    ("ending", "is_program", "is_board"),
    [
        (TransportClosedError("the port is gone"), False, True),
        (TransportClosedError("tcp 127.0.0.1:1: Connection reset by peer"), True, False),
        (PeerClosedError("tcp 192.168.1.7:1 ended the connection"), False, False),
    ],
)
async def test_programs_that_follow_each_other_share_no_reset_history(
    ending: TransportError, is_program: bool, is_board: bool
) -> None:
    world = await World().open()
    health = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time).health
    now_s = 100.0
    for _ in range(MIN_RESETS + 1):
        watch = health.connected(None, LinkStatistics(), now_s)
        watch.handle_event(ProtocolDetected(2), now_s)
        assert watch.was_alive
        now_s += 1.0
        health.disconnected(ending, is_program=is_program)
    health.connected(None, LinkStatistics(), now_s)
    assert (Code.RESET_LOOP in {each.code for each in health.find(now_s)}) is is_board
