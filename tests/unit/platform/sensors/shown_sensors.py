"""A sensing manager and a program that watches it, for tests of sensor nodes."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensing_manager import SensingManager
from rostether.platform.sensor_registration import SensorDescription
from rostether.serde.values import Message
from unit.platform.datagrams import running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until


class Shown:
    """What the manager shows: `sensors` by id; `state` returns the state and its text."""

    def __init__(self, network: MemoryNetwork, robot: TypedGraph, viewer: TypedGraph) -> None:
        self.network = network
        self.robot = robot
        self.viewer = viewer
        self.report = Lines()
        self.sensors: dict[str, Message] = {}

    async def watch(self) -> None:
        async for message in self.viewer.messages("/sensors", "sensing_platform/Sensors"):
            self.sensors = {each.id: each for each in message.sensors}

    def state(self, sensor_id: str) -> str:
        found = self.sensors.get(sensor_id)
        return f"{found.state} {found.state_text}".strip() if found is not None else ""

    async def has_state(self, sensor_id: str, state: str) -> None:
        await until(lambda: self.state(sensor_id) == state)


@asynccontextmanager
async def shown_sensors() -> AsyncIterator[Shown]:
    network, (manager, robot, viewer) = await typed_nodes("/sensing_manager", "/robot", "/viewer")
    shown = Shown(network, robot, viewer)
    async with running(SensingManager(manager, Lines()).run(), shown.watch()):
        await until(lambda: "/sensors_rename" in network.snapshot().services)
        yield shown


def described(
    sensor_type: str, message_type: str, *, unit: str = "", rate_hz: float = 100.0
) -> SensorDescription:
    return SensorDescription("robot3/front", "Robot 3", sensor_type, message_type, "Front", unit, "", rate_hz)
