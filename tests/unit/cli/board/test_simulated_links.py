"""`serve sim:`: a simulated board with the real client library, in a graph in one step."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any, cast

import pytest

from interop.ros1_peers import free_port
from programs import Peer, started
from rostether.cli.board.simulated_links import _report_events, simulated
from rostether.errors import BoardError, ConfigError
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.joining import join
from rostether.simulation.simavr.board_events import BoardEvent
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from rostether.transports.address import PtyAddress, SerialAddress, SimAddress
from rostether.transports.address_parser import parse_address
from unit.simulation.simavr.programs import build

pytestmark = pytest.mark.simavr

SKETCH = """
#include <ros.h>
#include <std_msgs/Float32.h>
#include <std_msgs/Empty.h>

ros::NodeHandle nh;
std_msgs::Float32 volts;
ros::Publisher volts_publisher("volts", &volts);
void toggle(const std_msgs::Empty&) { digitalWrite(13, !digitalRead(13)); }
ros::Subscriber<std_msgs::Empty> toggler("toggle", &toggle);

void setup() {
  pinMode(13, OUTPUT);
  nh.initNode();
  nh.advertise(volts_publisher);
  nh.subscribe(toggler);
}

void loop() {
  static unsigned long due;
  if (millis() - due >= 100) {
    due = millis();
    volts.data = analogRead(0) * 5.0 / 1024;
    volts_publisher.publish(&volts);
  }
  nh.spinOnce();
}
"""


class Lines:
    def __init__(self) -> None:
        self.lines: list[tuple[Level, str]] = []

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        self.lines.append((level, text))

    async def wait_for(self, part: str) -> None:
        async with asyncio.timeout(60):
            while not any(part in text for _, text in self.lines):
                await asyncio.sleep(0.01)


async def test_a_sketch_joins_the_graph_in_one_step(tmp_path: Path) -> None:
    sketch = tmp_path / "volt_meter" / "volt_meter.ino"
    sketch.parent.mkdir()
    sketch.write_text(SKETCH)
    uri = f"http://localhost:{free_port()}"
    address = f"sim:{sketch}?adc=A0:2.5&watch=D13"
    async with started("serve", address, ROS_MASTER_URI=uri) as serve:
        await serve.wait_for("Setup publisher on volts")
        await _use(uri, serve)


async def _use(uri: str, serve: Peer) -> None:
    async with join("tester", environ={"ROS_MASTER_URI": uri}) as graph:
        async with asyncio.timeout(60):
            async for message in graph.messages("/volts"):
                assert message.data == pytest.approx(2.5, abs=0.01)
                break
        assert "/volt_meter" in (await graph.snapshot()).nodes
        await _command_node(graph)
        publisher = await graph.publisher("/toggle", "std_msgs/Empty")
        await serve.wait_for("pin D13 level=0")
        async with asyncio.timeout(60):
            while "pin D13 level=1" not in serve.text:
                publisher.publish()
                await asyncio.sleep(0.1)


async def _command_node(graph: TypedGraph) -> None:
    """Check that the board's node shows its pins, and accepts only commands that change its environment."""
    command = await graph.publisher("/volt_meter_simulation/command", "std_msgs/String")
    assert await command.wait_for_subscriber(60)
    reported: list[tuple[str, Callable[[Any], bool]]] = [
        ("adc A0=1.25 A1=5", lambda state: state["values"]["adc"] == {"A0": "1.25", "A1": "5"}),
        ("range 0.5", lambda state: state["values"]["range"] == "0.5" and state["pins"]["D6"] != "out1"),
        ("pin D7=1", lambda state: state["pins"]["D7"] == "in1"),
        ("fault flip=2", lambda state: "fault flip=2" in state["error"]),
        ("quit", lambda state: "'quit' is not one of adc" in state["error"]),
        ("adc A0=2.5\nquit", lambda state: "one line" in state["error"]),
        ("pin D7=0", lambda state: state["pins"]["D7"] == "in0" and not state["error"]),
    ]
    async with asyncio.timeout(60):
        states = aiter(graph.messages("/volt_meter_simulation/state"))
        state = json.loads((await anext(states)).data)
        assert (state["board"], state["mcu"], state["servos"]) == ("uno", "atmega328p", {})
        assert len(state["pins"]) == 20
        command.publish(data="wheels left=D3/D8")
        odometry = await anext(aiter(graph.messages("/volt_meter_simulation/odom")))
        assert (odometry.child_frame_id, odometry.pose.pose.orientation.w) == ("base_link", 1)
        for line, is_done in reported:
            command.publish(data=line)
            while not is_done(json.loads((await anext(states)).data)):
                pass


async def test_links_are_opened_at_their_ports_with_names() -> None:
    program = build("tick")
    links = [
        parse_address(f"sim:{program}"),
        parse_address("pty:/tmp/x"),
        parse_address(f"sim:{program}"),
        parse_address(f"sim:{program}?name=arm&ns=lab&board=nano"),
    ]
    lines = Lines()
    async with simulated(links, lines) as opened:
        stem = program.stem.replace("-", "_")
        assert [link.name for link in opened] == [stem, None, f"{stem}_2", "arm"]
        assert [type(link) for link in opened] == [SerialAddress, PtyAddress, SerialAddress, SerialAddress]
        assert opened[3].ns == "lab"
        assert len({str(link) for link in opened}) == 4
        assert f"simulated nano runs {program} at {opened[3]}" in [text for _, text in lines.lines]
    assert not any("has ended" in text for _, text in lines.lines)


async def test_warnings_of_the_board_are_reported() -> None:
    lines = Lines()
    async with simulated([parse_address(f"sim:{build('tick')}?watch=serial")], lines):
        await lines.wait_for("serial data=")
    levels = {level for level, text in lines.lines if "serial data=" in text}
    assert levels == {Level.INFO}


async def test_mistakes_are_reported_before_anything_is_served() -> None:
    with pytest.raises(ConfigError, match="no simulated board 'due'"):
        async with simulated([parse_address("sim:x.elf?board=due")], Lines()):
            pass
    with pytest.raises(BoardError, match="watch D99"):
        async with simulated([parse_address(f"sim:{build('tick')}?watch=D99")], Lines()):
            pass
    with pytest.raises(BoardError, match="does not exist"):
        async with simulated([parse_address("sim:nowhere.ino")], Lines()):
            pass


async def test_boards_that_end_because_another_cannot_start_are_not_reported() -> None:
    lines = Lines()
    links = [parse_address(f"sim:{build('tick')}"), parse_address("sim:nowhere.ino")]
    with pytest.raises(BoardError, match="does not exist"):
        async with simulated(links, lines):
            pass
    # The report of an end would follow in the next steps of the loop.
    await asyncio.sleep(0.05)
    assert not any("has ended" in text for _, text in lines.lines)


async def test_a_warning_that_repeats_is_one_line() -> None:
    class Board:
        recent = ()

        async def events(self) -> AsyncIterator[BoardEvent]:
            for number in range(1000):
                yield BoardEvent("lost_serial", number / 1000)
                yield BoardEvent("pin", number / 1000)

    lines = Lines()
    await _report_events(cast(SimulatedBoard, Board()), SimAddress("x.elf"), lines)
    assert sum("lost serial" in text for _, text in lines.lines) == 1
    assert sum(level is Level.INFO for level, _ in lines.lines) == 1000
