from __future__ import annotations

import asyncio
import time

from rostether.bridge.board_node import BoardNode
from rostether.bridge.session import Session
from rostether.bridge.settings import BridgeSettings
from rostether.rosserial import topic_id as ids
from rostether.transports.memory import memory_pair
from unit.bridge.nodes import STORE, World, topic_info
from unit.bridge.raw_board import RawBoard
from waiting import until

ENDPOINTS = 250


async def test_the_largest_board_is_bridged_within_two_seconds() -> None:
    world = await World().open()
    loop = asyncio.get_running_loop()
    node = BoardNode(world.board, STORE, world.reporter, loop.time, BridgeSettings())
    ours, theirs = memory_pair()
    used_s = time.process_time()
    RawBoard(theirs, *((ids.PUBLISHER, topic_info(f"l{n}", topic_id=125 + n)) for n in range(ENDPOINTS)))
    session = Session(ours, node)
    session.start()
    try:
        await until(lambda: session.link.is_settled, "the negotiation")
        while sum(name.startswith("/l") for name in (await world.peer.snapshot()).topics) < ENDPOINTS:
            await asyncio.sleep(0.001)
        # Nothing waits here: the measured time is the CPU time of this process.
        assert time.process_time() - used_s < 2.0
        assert not world.reporter.having("too many announcements")
    finally:
        await session.stop()
        await node.close()
