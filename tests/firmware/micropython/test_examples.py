"""The examples for a Pico, with the real bridge; the pins and the parts on them are simulated."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from firmware.micropython.boards import EXAMPLES, PROGRAMS, usb_board
from firmware.platforms.node_harness import NodeHarness, node_harness
from rostether.serde.values import Message
from waiting import until

PICO = PROGRAMS / "pico"
NAMES = sorted(each.stem for each in EXAMPLES.glob("*.py"))


@pytest.mark.parametrize("name", NAMES)
def test_each_begins_with_its_purpose_its_wiring_and_a_command(name: str) -> None:
    text = (EXAMPLES / f"{name}.py").read_text()
    assert text.startswith(f"# {name.capitalize()}: ")
    assert re.search(r"^# Wiring:  \S", text, re.MULTILINE)
    assert re.search(r"^# Try it:  rostether ", text, re.MULTILINE)
    for typed in re.findall(r"rostether (?:topic pub|topic echo)[^\n]*? /(\w+)", text):
        assert f'"{typed}"' in text, f"{name} has no topic {typed}"


async def test_blink(library: Path) -> None:
    async with (
        usb_board(EXAMPLES / "blink.py", library, folders=[PICO]) as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        await _publish(harness, "/toggle_led", "std_msgs/Empty")
        await until(lambda: board.lines, "the LED")
        await _publish(harness, "/toggle_led", "std_msgs/Empty")
        await until(lambda: len(board.lines) > 1, "the LED")
        assert board.lines == ["pin LED 1", "pin LED 0"]


async def test_servo(library: Path) -> None:
    async with (
        usb_board(EXAMPLES / "servo.py", library, folders=[PICO]) as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        await _publish(harness, "/servo", "std_msgs/UInt16", data=90)
        await until(lambda: len(board.lines) >= 2, "a pulse")
        assert board.lines == ["frequency 15 50", "pulse 15 1472000"]


async def test_ultrasound(library: Path) -> None:
    async with (
        usb_board(EXAMPLES / "ultrasound.py", library, folders=[PICO]) as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        message = await _message(harness, "/ultrasound", "sensor_msgs/Range")
    assert message.range == pytest.approx(0.5, abs=0.001)
    assert (message.header.frame_id, message.radiation_type) == ("ultrasound", 0)
    assert message.field_of_view == pytest.approx(0.26)


async def test_imu_that_is_plugged_in_late(library: Path) -> None:
    async with (
        usb_board(EXAMPLES / "imu.py", library, folders=[PICO]) as board,
        node_harness() as harness,
        harness.bridge(board.address),
    ):
        message = await _message(harness, "/imu_data", "sensor_msgs/Imu")
    assert message.linear_acceleration.z == pytest.approx(9.80665)
    assert message.angular_velocity.z == pytest.approx(4.3633, abs=0.001)
    assert list(message.orientation_covariance) == [-1.0] + [0.0] * 8


async def _publish(harness: NodeHarness, topic: str, type_name: str, **fields: Any) -> None:
    publisher = await harness.graph.publisher(topic, type_name)
    assert await publisher.wait_for_subscriber(60.0)
    publisher.publish(**fields)


async def _message(harness: NodeHarness, topic: str, type_name: str) -> Message:
    async for message in harness.graph.messages(topic, type_name):
        return message
    raise AssertionError(f"{topic} has ended")
