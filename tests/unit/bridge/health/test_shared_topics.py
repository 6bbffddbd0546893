from __future__ import annotations

import asyncio

from rostether.bridge.board_node import BoardNode
from rostether.bridge.board_registry import Board
from rostether.bridge.health.shared_topics import SharedTopics
from rostether.bridge.session import Session
from rostether.graph.memory_network import MemoryNetwork
from rostether.transports.memory import memory_pair
from unit.bridge.doubles import RecordingReporter
from unit.bridge.nodes import STORE
from unit.bridge.sketch_board import SketchBoard
from unit.bridge.virtual_time import on_virtual_time


async def connected(network: MemoryNetwork, name: str, namespace: str = "/") -> Board:
    """Return a board with two topics and a service that only this kind of board has, and one topic that many
    nodes publish.
    """
    graph = await network.join(name, namespace=namespace)
    node = BoardNode(graph, STORE, RecordingReporter(), asyncio.get_running_loop().time)
    ours, theirs = memory_pair(can_pause=False)
    board = Board(name, node, Session(ours, node))
    assert board.session is not None
    board.session.start()
    sketch = SketchBoard(theirs).publisher("range", "sensor_msgs/Range").publisher("tf", "tf/tfMessage")
    empty = STORE.registry.service_type("std_srvs/Empty")
    sketch.link.add_service_server("calibrate", "std_srvs/Empty", empty.request.md5sum, empty.response.md5sum)
    sketch.subscriber("led").plug_in()
    async with asyncio.timeout(60):
        while len(list(node.endpoints)) < 4:
            await asyncio.sleep(0.01)
    return board


@on_virtual_time
async def test_topics_of_several_boards_are_reported_once() -> None:
    network, reporter = MemoryNetwork(), RecordingReporter()
    shared = SharedTopics(reporter)
    boards = [await connected(network, "/uno_1"), await connected(network, "/uno_3", "/lab")]
    shared.check(boards)
    assert reporter.texts == []
    boards.append(await connected(network, "/uno_2"))
    for _ in range(2):
        shared.check(boards)
    hint = "--ns-per-board gives each board its own topics"
    assert reporter.texts == [
        f"/uno_1 and /uno_2 publish /range; {hint}",
        f"/uno_1 and /uno_2 subscribe to /led; {hint}",
        "/uno_1 and /uno_2 offer /calibrate; --ns-per-board gives each board its own services",
    ]
    for board in boards:
        assert board.session is not None
        assert board.node is not None
        await board.session.stop()
        await board.node.close()
