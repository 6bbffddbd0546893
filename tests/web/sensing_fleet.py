"""A fleet with sensors, in this process: robots that answer a monitor, and sensors that register with a
manager.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import rostether
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.command_link import ReceiverSettings
from rostether.platform.fleet import FleetSettings
from rostether.platform.fleet_monitor import FleetMonitor
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.sensing_manager import SensingManager
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.jpeg import PictureChange, draw_test_picture
from rostether.platform.sensors.registered_sensor import RegisteredSensor, registered_sensor
from unit.platform.datagrams import loopback_group, running
from unit.platform.typed_nodes import Lines

SENSORS = {
    "battery": ("std_msgs/Float64", "V"),
    "temperature": ("sensor_msgs/Temperature", "°C"),
    "distance": ("sensor_msgs/Range", "m"),
    "load": ("std_msgs/Float64", "%"),
    "camera": ("sensor_msgs/CompressedImage", ""),
}
PERIOD_S = 0.2
_SIZE = PictureChange(width=320, height=240)


@asynccontextmanager
async def sensing_fleet(
    master: str, robots: int, cameras: int, *, has_manager: bool = True
) -> AsyncIterator[list[RegisteredSensor]]:
    """Run robots with five sensors each at 5 Hz; only the first `cameras` send pictures.

    Yield the sensors, in the order of their registration.
    """
    address = loopback_group()
    sensors: list[RegisteredSensor] = []
    async with AsyncExitStack() as stack:

        async def join(name: str) -> TypedGraph:
            return await stack.enter_async_context(rostether.join(name, master=master))

        node, monitor = await join("robots"), await join("fleet_monitor")
        tasks = [FleetMonitor(monitor, FleetSettings(address=address), Lines()).run()]
        if has_manager:
            tasks.append(SensingManager(await join("sensing_manager"), Lines()).run())
        for number in range(1, robots + 1):
            tasks.append(receive_topic(node, _receiver(number, address), Lines()))
            tasks += [
                _publish(node, number, name, sensors)
                for name in SENSORS
                if name != "camera" or number <= cameras
            ]
        await stack.enter_async_context(running(*tasks))
        yield sensors


def _receiver(number: int, address: GroupAddress) -> ReceiverNodeSettings:
    framed = ReceiverSettings(number, kind=bytes.fromhex("7528cb4c"))
    return ReceiverNodeSettings(
        "arduino_control/ArduinoControl", f"/robot{number}/command", address, framed=framed
    )


async def _publish(node: TypedGraph, number: int, name: str, sensors: list[RegisteredSensor]) -> None:
    message_type, unit = SENSORS[name]
    description = SensorDescription(
        f"robot{number}/{name}",
        f"Robot {number}",
        "CAMERA" if name == "camera" else "ANALOG",
        message_type,
        name,
        unit,
        rate_hz=1 / PERIOD_S,
    )
    async with registered_sensor(node, description, Lines()) as sensor:
        sensors.append(sensor)
        sensor.set_state("ready")
        for count in range(1 << 31):
            if sensor.is_wanted:
                sensor.publish(**_fields(name, count, number + count % 10 / 10))
            await asyncio.sleep(PERIOD_S)


def _fields(name: str, count: int, value: float) -> dict[str, Any]:
    if name == "camera":
        return {"format": "jpeg", "data": draw_test_picture(count % 20, _SIZE)}
    if name == "distance":
        return {"range": value, "min_range": 0.02, "max_range": 40.0}
    return {name if name == "temperature" else "data": value}
