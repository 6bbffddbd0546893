"""Additional features of the graph in memory: stored logs, and a time that tests set."""

from __future__ import annotations

from rostether.graph.log_message import LogRecord
from rostether.graph.memory_network import MAX_LOGS, MemoryNetwork
from rostether.graph.ports import Level
from rostether.rostime import Time


async def test_logs_are_kept_and_bounded() -> None:
    network = MemoryNetwork()
    node = await network.join("/board")
    node.log(Level.WARN, "too hot")
    assert list(network.logs) == [LogRecord("/board", Level.WARN, "too hot")]
    for number in range(MAX_LOGS + 5):
        node.log(Level.DEBUG, str(number))
    assert len(network.logs) == MAX_LOGS
    await node.close()


async def test_time_is_an_argument() -> None:
    network = MemoryNetwork(now=lambda: Time(5, 6))
    node = await network.join("/board")
    assert node.now() == Time(5, 6)
    network.now = lambda: Time(7, 8)
    assert node.now() == Time(7, 8)
    await node.close()
