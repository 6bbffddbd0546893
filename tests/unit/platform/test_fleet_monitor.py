from __future__ import annotations

import asyncio

import pytest

from rostether.errors import TransportError
from rostether.graph.typed_graph import TypedGraph
from rostether.platform import fleet_monitor
from rostether.platform.command_link import ReceiverSettings, SenderSettings
from rostether.platform.fleet import FleetSender, FleetSettings
from rostether.platform.fleet_monitor import FleetMonitor
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress
from unit.platform.datagrams import loopback_group, running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until

KIND = bytes.fromhex("7528cb4c")


def robot(graph: TypedGraph, number: int, address: GroupAddress, lines: Lines) -> asyncio.Task[None]:
    settings = ReceiverNodeSettings(
        "arduino_control/ArduinoControl",
        f"/robot{number}",
        address,
        framed=ReceiverSettings(number, kind=KIND),
    )
    return asyncio.ensure_future(receive_topic(graph, settings, lines))


async def test_robots_are_shown_stopped_and_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fleet_monitor, "LOST_S", 1.2)
    address, lines = loopback_group(), Lines()
    _, (node, base, page) = await typed_nodes("/robots", "/fleet_monitor", "/page")
    robots = {number: robot(node, number, address, Lines()) for number in (1, 2)}
    states: dict[int, str] = {}

    def show(message: object) -> None:
        states.clear()
        states.update({each.id: each.state for each in message.robots})  # type: ignore[attr-defined]

    await page.subscriber("/fleet", "sensing_platform/Fleet", show)
    settings = FleetSettings(address=address)
    sender = FleetSender(FleetSettings(SenderSettings(1, to_groups=False, kind=KIND), address), Lines())
    async with running(FleetMonitor(base, settings, lines).run()):
        await until(lambda: states == {1: "stopped", 2: "stopped"})
        driving = asyncio.ensure_future(sender.drive(bytes(16)))
        await until(lambda: states == {1: "moving", 2: "stopped"})
        answer = await page.call("/fleet_stop", "sensing_platform/StopRobots", {"robot": 0})
        assert answer.confirmed == [1, 2]
        await until(lambda: states == {1: "stopped", 2: "stopped"})
        with pytest.raises(TransportError, match="after this sender started"):
            await driving
        sender.close()
        robots[2].cancel()
        await until(lambda: states == {1: "stopped", 2: "lost"})
        assert any(each.endswith("has not answered for 1.2 s; check its network") for each in lines.texts)
        robots[2] = robot(node, 2, address, Lines())
        await until(lambda: states == {1: "stopped", 2: "stopped"})
    for each in robots.values():
        each.cancel()
    await asyncio.wait(robots.values())
