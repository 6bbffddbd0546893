from __future__ import annotations

import asyncio
from typing import Any

import pytest

from rostether.bridge.board_node import BoardNode
from rostether.bridge.board_registry import Board
from rostether.bridge.health.board_status import TYPE
from rostether.bridge.health.health_round import HealthRound
from rostether.bridge.session import Session
from rostether.graph.ports import Level
from rostether.rosserial import topic_id as ids
from rostether.rosserial.packets import TopicInfo
from rostether.transports.address import ProgramSize
from rostether.transports.memory import memory_pair
from unit.bridge.nodes import STORE, World, text, topic_info
from unit.bridge.raw_board import RawBoard
from unit.bridge.sketch_board import SketchBoard, every, hello, publish, stamped
from unit.bridge.virtual_time import run


class Rounds(World):
    """A world with one board in the round."""

    async def begin(self, *, publishes: bool = True) -> None:
        await self.open()
        loop = asyncio.get_running_loop()
        node = BoardNode(self.board, STORE, self.reporter, loop.time)
        node.hardware_id = "95530343"
        self.entry = Board("/board", node)
        self.round = HealthRound(lambda: [self.entry], STORE, self.reporter, loop.time, publishes=publishes)
        self.round.start()

    async def connect(self, baud: int | None = None) -> Any:
        ours, theirs = memory_pair(can_pause=False)
        assert self.entry.node is not None
        self.entry.session = Session(ours, self.entry.node, baud=baud)
        self.entry.session.start()
        return theirs

    async def statuses(self) -> list[Any]:
        received = await self.listen("/diagnostics", TYPE)
        await asyncio.sleep(6.5)
        codec = STORE.codec(TYPE)
        return [codec.decode(payload) for payload in received]

    async def end(self) -> None:
        await self.round.close()
        if self.entry.session is not None:
            await self.entry.session.stop()
        assert self.entry.node is not None
        await self.entry.node.close()


def values(status: Any) -> dict[str, str]:
    return {each.key: each.value for each in status.values}


def test_a_healthy_board_once_a_second() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        assert world.entry.node is not None
        world.entry.node.program = ProgramSize(14532, 32256, 812, 0)
        wire = await world.connect(115200)
        board = SketchBoard(wire, turn=every(0.05, publish("range", stamped)))
        board.publisher("range", "sensor_msgs/Range").subscriber("led").plug_in()
        arrays = await world.statuses()
        # Five rounds, and one immediately for the new subscriber.
        assert len(arrays) == 6
        (status,) = arrays[-1].status
        assert (status.level, status.name, status.hardware_id) == (0, "board: rosserial", "95530343")
        assert status.message == "no problem found"
        reported = values(status)
        assert reported["state"] == "connected"
        assert reported["protocol version"] == "2"
        assert reported["baud rate"] == "115200"
        assert int(reported["publisher range buffer [bytes]"]) > 0
        assert reported["checksum errors"] == "0"
        assert reported["reconnects"] == "0"
        assert float(reported["publisher range [Hz]"]) == pytest.approx(20, abs=2)
        assert reported["publisher range dropped"] == "0"
        assert reported["subscriber led [messages]"] == "0"
        assert float(reported["round trip [ms]"]) < 20
        assert int(reported["received [bytes/s]"]) > 500
        assert reported["flash [bytes]"] == "14532"
        assert (reported["RAM [bytes]"], reported["RAM limit [bytes]"]) == ("812", "unknown")
        assert {"clock offset [ms]", "clock drift [ppm]", "sent [bytes]", "loop late [ms]"} <= reported.keys()
        assert arrays[-1].header.stamp.to_ns() > arrays[0].header.stamp.to_ns()
        await board.unplug()
        await world.end()

    run(main())


def test_a_finding_is_reported_once_and_is_in_the_status() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        wire = await world.connect(57600)
        board = SketchBoard(wire, turn=every(0.5, lambda it: it.write(b"distance 42 cm\r\n"))).plug_in()
        arrays = await world.statuses()
        (status,) = arrays[-1].status
        assert status.level == 1
        assert "distance 42 cm" in status.message
        assert "distance 42 cm" in values(status)["finding text-between-frames"]
        lines = [line for line in world.reporter.lines if "distance 42 cm" in line[1]]
        assert len(lines) == 1
        assert lines[0][0] is Level.WARN
        assert len([log for log in world.network.logs if "distance 42 cm" in log.text]) == 1
        await board.unplug()
        await world.end()

    run(main())


def test_a_lost_board_is_an_error() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        arrays = await world.statuses()
        (status,) = arrays[-1].status
        assert (status.level, status.message) == (2, "not connected")
        assert values(status)["state"] == "disconnected"
        await world.end()

    run(main())


def test_reconnects_are_counted() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        for _ in range(3):
            board = SketchBoard(await world.connect(), turn=every(0.1, publish("chatter", hello)))
            board.publisher("chatter").plug_in()
            await asyncio.sleep(1.0)
            assert world.entry.session is not None
            await world.entry.session.stop()
            await board.unplug()
        board = SketchBoard(await world.connect()).plug_in()
        status = (await world.statuses())[-1].status[0]
        assert values(status)["reconnects"] == "3"
        # The port of a board with built-in USB disappears when the board resets.
        assert "finding reset-loop" in values(status)
        await board.unplug()
        await world.end()

    run(main())


def test_without_a_subscriber_nothing_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        await asyncio.sleep(3.0)
        await world.end()

    def fail(*_arguments: object) -> None:
        raise AssertionError("a status was made without a subscriber")

    monkeypatch.setattr("rostether.bridge.health.diagnostics_message.StatusWriter.array", fail)
    run(main())


def test_it_can_be_turned_off() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin(publishes=False)
        await asyncio.sleep(3.0)
        assert "/diagnostics" not in world.network.snapshot().topics
        await world.end()

    run(main())


def test_drops_are_reported_by_topic() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        info = topic_info("led", topic_id=100, buffer_size=100)
        RawBoard(await world.connect(9600), (ids.SUBSCRIBER, info))
        await asyncio.sleep(1.0)
        publisher = await world.peer.advertise("/led", STORE.registry.message_type("std_msgs/String"))
        await asyncio.sleep(0.5)
        for _ in range(10):
            publisher.publish_raw([text("x" * 90)] * 100)
            await asyncio.sleep(0.1)
        status = (await world.statuses())[-1].status[0]
        reported = values(status)
        assert int(reported["subscriber led dropped"]) > 100
        assert "led is faster than the board can receive" in reported["finding messages-lost"]
        await world.end()

    run(main())


def test_a_defect_is_reported_once_and_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        await asyncio.sleep(4.0)
        assert len(world.reporter.having("diagnostics failed: ZeroDivisionError")) == 1
        await world.end()

    def fail(*_arguments: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr("rostether.bridge.findings.board_health.BoardHealth.report", fail)
    run(main())


def test_stale_headers_are_in_the_status_and_once_in_the_log() -> None:
    async def main() -> None:
        world = Rounds()
        await world.begin()
        stale = TopicInfo(125, "battery", "sensor_msgs/BatteryState", "476f837fa6771f6e16e3bf4ef96f8770", 280)
        RawBoard(await world.connect(), (ids.PUBLISHER, stale))
        status = (await world.statuses())[-1].status[0]
        assert "lacks 'float32 temperature'" in values(status)["finding stale-headers"]
        assert status.level == 2
        assert len(world.reporter.having("lacks 'float32 temperature'")) == 1
        await world.end()

    run(main())
