"""The platform's nodes on a ROS 2 graph: a joystick drives a robot over multicast, a sensor registers."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

import rostether
from programs import started
from rostether.graph.typed_handles import TypedPublisher
from unit.cli.ros2.zenoh_world import ZenohWorld
from unit.platform.datagrams import loopback_group

pytestmark = pytest.mark.slow


async def repeat(publisher: TypedPublisher[...], **fields: object) -> None:
    while True:
        publisher.publish(**fields)
        await asyncio.sleep(0.05)


async def test_a_joystick_drives_a_robot_and_a_sensor_registers(world: ZenohWorld, tmp_path: Path) -> None:
    address = loopback_group()
    # The group of framed commands is that of a fleet.
    both = ("--ros2", "zenoh", "_interface:=lo", "_framed:=true", f"_sending_port:={address.port}")
    receiving = ("_topic:=robot_control", "_type:=arduino_control/ArduinoControl", *both)
    async with (
        rostether.join("stick", ros2="zenoh") as graph,
        started("role", "arduino-control", "--ros2", "zenoh"),
        started("role", "multicast-topic-bridge", "_topic:=arduino_control", *both) as bridge,
        started("role", "multicast-topic-receiver", *receiving) as receiver,
        started(
            "role", "sensing-manager", "--ros2", "zenoh", f"_state_file:={tmp_path / 's.json'}"
        ) as manager,
        started("role", "digital-tester", "--ros2", "zenoh", "_platform_name:=Robot3") as tester,
    ):
        await bridge.wait_for("sending /arduino_control to 239.255.82.83:")
        await receiver.wait_for("receiving arduino_control/ArduinoControl from 239.255.82.83:")
        joy = await graph.publisher("/joy", "sensor_msgs/msg/Joy")
        publishing = asyncio.ensure_future(repeat(joy, axes=[0.0, 1.0]))
        try:
            control = await graph.wait_for_message(
                "/robot_control", "arduino_control/msg/ArduinoControl", timeout_s=60
            )
        finally:
            publishing.cancel()
        assert control.speed == 1.0
        await tester.wait_for("registered for topic sensor_node0")
        value = await graph.wait_for_message("/sensor_node0", "std_msgs/msg/Float64", timeout_s=60)
        assert value.data in range(101)
        # A camera that an earlier manager has registered.
        await graph.publisher("/sensor_node7", "sensor_msgs/msg/CompressedImage")
        found: dict[str, tuple[str, str]] = {}
        async with asyncio.timeout(60):
            async for sensors in graph.messages("/sensors", "sensing_platform/msg/Sensors"):
                found = {each.id: (each.sensor_type, each.state) for each in sensors.sensors}
                if found == {"sensor_node0": ("DIGITAL", "ready"), "sensor_node7": ("CAMERA", "ready")}:
                    break
        for words, line in (
            (("rename", "sensor_node0", "Level"), "sensor_node0: Level"),
            (("show", "Level"), "platform: Robot3"),
            (("list",), "  sensor_node0  DIGITAL  ready  /sensor_node0  Level"),
        ):
            async with started("sensor", *words, "--ros2", "zenoh") as tool:
                await tool.wait_for(line)
        async with started(
            "role", "camera", "--ros2", "zenoh", "_source:=test", "_platform_name:=R3"
        ) as camera:
            await camera.wait_for("registered as R3/camera, on topic /sensors/R3/camera")
            picture = await graph.wait_for_message(
                "/sensors/R3/camera", "sensor_msgs/msg/CompressedImage", timeout_s=60
            )
        assert bytes(picture.data).startswith(b"\xff\xd8")
        assert not manager.process.returncode
