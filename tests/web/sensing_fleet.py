"""A fleet with sensors, in this process: robots that answer a monitor, and their sensors at a manager."""

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
from rostether.platform.sensors.jpeg import PictureChange, drawn_picture
from rostether.platform.sensors.registered_sensor import SensorDescription, registered_sensor
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
async def sensing_fleet(master: str, robots: int, cameras: int) -> AsyncIterator[None]:
    """Have robots with five sensors each at 5 Hz; only the first `cameras` send pictures."""
    address = loopback_group()
    async with AsyncExitStack() as stack:
        node, manager, monitor = [
            await stack.enter_async_context(rostether.join(each, master=master))
            for each in ("robots", "sensing_manager", "fleet_monitor")
        ]
        works = [
            SensingManager(manager, Lines()).run(),
            FleetMonitor(monitor, FleetSettings(address=address), Lines()).run(),
        ]
        for number in range(1, robots + 1):
            works.append(receive_topic(node, _receiver(number, address), Lines()))
            works += [
                _publish(node, number, name) for name in SENSORS if name != "camera" or number <= cameras
            ]
        await stack.enter_async_context(running(*works))
        yield


def _receiver(number: int, address: GroupAddress) -> ReceiverNodeSettings:
    framed = ReceiverSettings(number, kind=bytes.fromhex("7528cb4c"))
    return ReceiverNodeSettings(
        "arduino_control/ArduinoControl", f"/robot{number}/command", address, framed=framed
    )


async def _publish(node: TypedGraph, number: int, name: str) -> None:
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
        sensor.set_state("ready")
        for count in range(1 << 31):
            if sensor.is_wanted:
                sensor.publish(**_fields(name, count, number + count % 10 / 10))
            await asyncio.sleep(PERIOD_S)


def _fields(name: str, count: int, value: float) -> dict[str, Any]:
    if name == "camera":
        return {"format": "jpeg", "data": drawn_picture(count % 20, _SIZE)}
    if name == "distance":
        return {"range": value, "min_range": 0.02, "max_range": 40.0}
    return {name if name == "temperature" else "data": value}
