"""Hundreds of reconnects leave nothing behind: no descriptor, task, registration or memory."""

from __future__ import annotations

import asyncio
import gc
import sys
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from effort import effort
from rostether.bridge.settings import BridgeSettings
from unit.bridge.line_boards import Bridge, TcpBoard, numbered
from waiting import until

pytestmark = pytest.mark.slow

RECONNECTS = effort(150, 1000)
# Until then caches fill.
WARM_UP = 100
# asyncio keeps up to a hundred canceled timers.
MAX_GROWTH_BYTES = (RECONNECTS + 100) * 512


def _descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def _objects() -> Counter[type]:
    return Counter(map(type, gc.get_objects()))


@pytest.fixture
def _traced() -> Iterator[None]:
    """Count the bytes that Python has allocated, because the size of the process also depends on earlier
    tests.
    """
    tracemalloc.start()
    yield
    tracemalloc.stop()


async def _come_and_go(bridge: Bridge, board: TcpBoard, received: list[int], number: int) -> None:
    await board.connect()
    requests = board.requests
    await until(lambda: board.requests > requests, "a topic request")
    await board.send(numbered(number))
    await until(lambda: received[-1:] == [number], "the message")
    await board.hang_up()
    await until(
        lambda: not any(view.is_connected for view in bridge.supervisor.boards()), "the end of a session"
    )
    received.clear()
    bridge.reporter.lines.clear()
    bridge.network.logs.clear()


@pytest.mark.timeout(300)
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.usefixtures("_traced")
async def test_reconnects_leave_nothing_behind() -> None:
    async with Bridge(BridgeSettings(grace_s=60.0)) as bridge:
        received = await bridge.listen("/count")
        board = TcpBoard(bridge.port)
        for number in range(WARM_UP):
            await _come_and_go(bridge, board, received, number)
        gc.collect()
        await asyncio.sleep(0.1)
        before = _descriptors(), len(asyncio.all_tasks()), bridge.network.snapshot()
        held_bytes, _ = tracemalloc.get_traced_memory()
        objects = _objects()
        for number in range(RECONNECTS):
            await _come_and_go(bridge, board, received, number)
        gc.collect()
        await asyncio.sleep(0.1)
        assert (_descriptors(), len(asyncio.all_tasks()), bridge.network.snapshot()) == before
        assert tracemalloc.get_traced_memory()[0] - held_bytes < MAX_GROWTH_BYTES
        # A leak adds at least one object each time.
        grown = {kind: count for kind, count in (_objects() - objects).items() if count >= RECONNECTS * 0.8}
        assert not grown
