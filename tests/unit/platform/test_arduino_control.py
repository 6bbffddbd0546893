from __future__ import annotations

import asyncio
import itertools
import math
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.platform.arduino_control import (
    FORMULAS,
    StickSettings,
    publish_commands,
    radial_command,
    reference_command,
)
from unit.platform.typed_nodes import STORE, Lines, typed_nodes
from waiting import until

# The computation of the platform's original node, as a C++ program with the same 32-bit axes.
ORACLE = r"""
#include <math.h>
#include <stdio.h>
int main() {
  float left, forward;
  while (fread(&left, 4, 1, stdin) == 1 && fread(&forward, 4, 1, stdin) == 1) {
    double result[2] = {atan2(-left, forward) * 180 / 3.14159265359, sqrt(pow(forward, 2) + pow(left, 2))};
    if (fabs(left) < 0.1 && fabs(forward) < 0.1) result[1] = 0;
    fwrite(result, 8, 2, stdout);
  }
}
"""


def test_the_type_is_the_references() -> None:
    control = STORE.registry.message_type("arduino_control/ArduinoControl")
    assert control.md5sum == "7528cb4c6fd33cf9e3157bf84136adec"
    registration = STORE.registry.service_type("sensors/RegistrationService")
    assert registration.request.md5sum == "ba03e6be1518decf9b0a19989136c24d"
    assert registration.response.md5sum == "d8f94bae31b356b24d0427f80426d0c3"


async def test_one_command_for_each_message_and_one_warning() -> None:
    network, (node, other) = await typed_nodes("/arduino_control", "/joy_node")
    lines, commands = Lines(), []

    async def listen() -> None:
        async for message in other.messages("/arduino_control", "arduino_control/ArduinoControl"):
            commands.append((message.dir, message.speed))

    tasks = [asyncio.ensure_future(listen())]
    await until(lambda: "/arduino_control" in network.snapshot().topics)
    tasks.append(asyncio.ensure_future(publish_commands(node, StickSettings(), lines)))
    joy = await other.publisher("/joy", "sensor_msgs/Joy")
    await until(lambda: joy.subscriber_count)
    sent: tuple[list[float], ...] = ([0.0, 1.0], [], [1.0], [math.nan, 0.0], [-1.0, 0.0], [1.0])
    for axes in sent:
        joy.publish(axes=axes)
    await until(lambda: len(commands) == len(sent))
    for task in tasks:
        task.cancel()
    await asyncio.wait(tasks)
    assert [speed for _, speed in commands] == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    assert commands[4][0] == pytest.approx(90)
    assert len(lines.texts) == 2
    assert lines.texts[0].startswith("the joystick has 0 of the two axes that driving needs on /joy")


async def test_settings_that_make_no_sense() -> None:
    _, (node,) = await typed_nodes("/arduino_control")
    with pytest.raises(ConfigError, match="reference or radial, not 'fast'"):
        await publish_commands(node, StickSettings(formula="fast"), Lines())
    with pytest.raises(ConfigError, match="finite"):
        await publish_commands(node, StickSettings(deadzone=math.inf), Lines())


def test_forward_is_the_references_datagram() -> None:
    command = reference_command(0.0, 1.0, 0.1)
    datagram = struct.pack("<dd", command.direction_deg, command.speed)
    assert datagram.hex() == "0000000000000080000000000000f03f"


@pytest.mark.parametrize(
    ("left", "forward", "direction_deg"), [(0, 1, 0), (-1, 0, 90), (1, 0, -90), (-1, -1, 135), (1, -1, -135)]
)
@pytest.mark.parametrize("formula", FORMULAS.values(), ids=FORMULAS)
def test_directions(formula, left: float, forward: float, direction_deg: float) -> None:  # type: ignore[no-untyped-def]
    assert formula(left, forward, 0.1).direction_deg == pytest.approx(direction_deg)


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler (apt install g++)")
def test_the_reference_formula_in_cpp(tmp_path: Path) -> None:
    source = tmp_path / "oracle.cpp"
    source.write_text(ORACLE)
    subprocess.run(["g++", "-o", tmp_path / "oracle", source], check=True)
    steps = [struct.unpack("<f", struct.pack("<f", each / 37))[0] for each in range(-37, 38)]
    points = list(itertools.product(steps, steps))
    stdin = b"".join(struct.pack("<ff", *point) for point in points)
    answer = subprocess.run([tmp_path / "oracle"], input=stdin, capture_output=True, check=True).stdout
    theirs = list(struct.iter_unpack("<dd", answer))
    ours = [reference_command(*point, 0.1) for point in points]
    assert [each.speed for each in ours] == [speed for _, speed in theirs]
    # The last bit of a 32-bit angle depends on the C library.
    for mine, (direction_deg, _) in zip(ours, theirs, strict=True):
        assert mine.direction_deg == pytest.approx(direction_deg, rel=2.0**-22)
        if mine.direction_deg % 90 < 1e-4:
            assert mine.direction_deg == direction_deg


def test_the_references_dead_zone_is_a_square() -> None:
    assert reference_command(0.09, 0.09, 0.1).speed == 0.0
    assert reference_command(0.09, 0.1, 0.1).speed == pytest.approx(math.hypot(0.09, 0.1))
    assert reference_command(0.05, 0.0, 0.1).direction_deg == pytest.approx(-90)


def test_the_radial_formula_is_smooth_and_at_most_1() -> None:
    assert radial_command(0.06, 0.06, 0.1).speed == 0.0
    assert radial_command(0.0, 0.1001, 0.1).speed == pytest.approx(0.0001 / 0.9)
    assert radial_command(1.0, 1.0, 0.1).speed == 1.0
    assert radial_command(0.0, 0.55, 0.1).speed == pytest.approx(0.5)
    assert radial_command(1.0, 1.0, 1.0).speed == 0.0
