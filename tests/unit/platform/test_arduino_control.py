from __future__ import annotations

import asyncio
import math

import pytest

from rostether.errors import ConfigError
from rostether.platform.arduino_control import StickSettings, publish_commands
from unit.platform.typed_nodes import STORE, Lines, typed_nodes
from waiting import until


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
