"""Driving over real sockets: a robot stops when its driver ends, freezes or loses its connection."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import signal
import struct
import sys
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from rostether.gateways.foxglove.settings import FoxgloveSettings
from rostether.graph.memory_network import MemoryNetwork
from unit.gateways.foxglove.protocol_client import ProtocolClient, Stage, stage
from waiting import until

TOPIC = "/cmd_vel"
TWIST = "geometry_msgs/Twist"
STOP = bytes(48)

# Another program that drives like a page; it can be killed or frozen.
DRIVER = f"""
import json, struct, sys, time
from websockets.sync.client import connect
with connect(sys.argv[1], subprotocols=["foxglove.sdk.v1"], proxy=None) as page:
    channel = {{"id": 1, "topic": "{TOPIC}", "encoding": "ros1", "schemaName": "{TWIST}", "driver": "page"}}
    page.send(json.dumps({{"op": "advertise", "channels": [channel]}}))
    while '"drive"' not in str(page.recv()):
        pass
    while True:
        page.send(struct.pack("<BI6d", 1, 1, 0.5, 0, 0, 0, 0, 0))
        time.sleep(0.05)
"""


class Robot:
    """The robot's node: collects commands with the times of their arrival."""

    def __init__(self) -> None:
        self.commands: list[tuple[float, tuple[float, ...]]] = []

    def received(self, payloads: Any) -> None:
        for payload in payloads:
            self.commands.append((time.monotonic(), struct.unpack("<6d", payload)))

    @property
    def speeds(self) -> list[float]:
        return [values[0] for _, values in self.commands]

    @property
    def stops(self) -> list[float]:
        return [speed for speed in self.speeds if speed == 0.0]

    def stop_delay_s(self) -> float:
        """Return how long the robot moved after the last command that moved it."""
        moved_s = max(at_s for at_s, values in self.commands if any(values))
        return next(at_s for at_s, values in self.commands if at_s >= moved_s and not any(values)) - moved_s


@asynccontextmanager
async def driven() -> AsyncIterator[tuple[Stage, Robot]]:
    network = MemoryNetwork()

    async def join() -> Any:
        return await network.join("/web_teleop")

    async with stage(FoxgloveSettings(port=0), network=network, join_teleop=join) as there:
        robot = Robot()
        message_type = there.store.registry.message_type(TWIST)
        await there.robot.subscribe(TOPIC, message_type, robot.received)
        yield there, robot


async def entered(client: ProtocolClient, name: str = "page", **more: Any) -> dict[str, Any]:
    channel = {"id": 1, "topic": TOPIC, "encoding": "ros1", "schemaName": TWIST, "driver": name} | more
    await client.say("advertise", channels=[channel])
    return await client.wait("drive")


async def command(client: ProtocolClient, x: float) -> None:
    await client.publish(1, struct.pack("<6d", x, 0, 0, 0, 0, 0))


async def state(client: ProtocolClient, wanted: str) -> dict[str, Any]:
    return await client.wait("drive", lambda message: message["state"] == wanted)


async def test_a_command_is_published_and_followed_by_one_stop() -> None:
    async with driven() as (there, robot), there.client() as client:
        info = client.of("serverInfo")[0]
        assert info["metadata"]["features"] == "drive"
        assert (await entered(client))["state"] == "free"
        await command(client, 0.1)
        held = await state(client, "driving")
        assert held["driver"].startswith("page (127.0.0.1:")
        await until(lambda: robot.stops)
        assert robot.speeds == [0.1, 0.0]
        assert there.network.snapshot().topics[TOPIC].publishers == ("/web_teleop",)
        # After a second of silence, any client may drive.
        await client.wait("drive", lambda message: message["state"] == "free" and client.of("drive")[2:])
        assert robot.speeds == [0.1, 0.0]


async def test_commands_are_limited_by_parameters_of_the_node() -> None:
    async with driven() as (there, robot), there.client() as client:
        await entered(client)
        assert await there.robot.get_param("/web_teleop/max_linear") == 1.0
        await client.say("unadvertise", channelIds=[1])
        await there.robot.set_param("/web_teleop/max_linear", 0.05)
        await entered(client)
        await until(lambda: len(client.of("drive")) == 2)
        await command(client, 5.0)
        await until(lambda: robot.speeds)
        assert robot.speeds[0] == pytest.approx(0.05)


async def test_a_stop_before_the_topic_is_open_is_published_and_another_command_is_not() -> None:
    async with driven() as (there, robot), there.client() as moving, there.client() as stopping:
        channel = {"id": 1, "topic": TOPIC, "encoding": "ros1", "schemaName": TWIST, "driver": "page"}
        await moving.say("advertise", channels=[channel])
        await command(moving, 0.3)
        await state(moving, "free")
        assert robot.commands == []
        await stopping.say("advertise", channels=[channel])
        await command(stopping, 0.0)
        await until(lambda: robot.speeds)
        assert robot.speeds == [0.0]


async def test_the_second_learns_who_drives() -> None:
    async with driven() as (there, robot), there.client() as anna, there.client() as ben:
        await entered(anna, "Anna\n")
        await entered(ben, "Ben")
        await command(anna, 0.1)
        taken = await state(ben, "taken")
        assert taken["driver"].startswith("Anna (127.0.0.1:")
        await command(ben, 0.9)
        await until(lambda: robot.stops)
        assert 0.9 not in robot.speeds
        await anna.say("unadvertise", channelIds=[1])
        await ben.wait("drive", lambda message: message["state"] == "free" and len(ben.of("drive")) > 2)
        await command(ben, 0.2)
        await state(ben, "driving")
        await until(lambda: 0.2 in robot.speeds)


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        (
            {"schemaName": "std_msgs/String"},
            "only geometry_msgs/Twist, .* can be driven, not",
        ),
        ({"schemaName": "none/None"}, "cannot be driven"),
        ({"topic": "a b"}, "cannot be driven"),
        ({"encoding": "cdr"}, "messages are ros1 or json"),
    ],
)
async def test_what_cannot_be_driven_is_reported(more: dict[str, str], reason: str) -> None:
    async with driven() as (there, _), there.client() as client:
        channel = {"id": 1, "topic": TOPIC, "encoding": "ros1", "schemaName": TWIST, "driver": "page"}
        await client.say("advertise", channels=[channel | more])
        status = await client.wait("status")
        assert re.search(reason, status["message"]), status


async def test_a_bad_command_moves_nothing() -> None:
    async with driven() as (there, robot), there.client() as client:
        await entered(client)
        await client.publish(1, b"short")
        await command(client, float("nan"))
        await client.wait("status", lambda message: "NaN" in message["message"])
        assert robot.commands == []


async def test_without_teleop_a_driver_is_an_ordinary_publisher() -> None:
    async with stage() as there, there.client() as client:
        assert client.of("serverInfo")[0]["metadata"]["features"] == ""
        channel = {"id": 1, "topic": TOPIC, "encoding": "ros1", "schemaName": TWIST, "driver": "page"}
        await client.say("advertise", channels=[channel])
        await until(lambda: TOPIC in there.network.snapshot().topics)
        assert there.network.snapshot().topics[TOPIC].publishers == ("/foxglove",)


async def test_a_topic_is_driven_as_one_type() -> None:
    async with driven() as (there, _), there.client() as first, there.client() as second:
        await entered(first)
        channel = {"id": 1, "topic": TOPIC, "encoding": "ros1", "driver": "page"}
        await second.say("advertise", channels=[channel | {"schemaName": "geometry_msgs/TwistStamped"}])
        status = await second.wait("status")
        assert "driven as geometry_msgs/Twist, not as geometry_msgs/TwistStamped" in status["message"]


async def test_when_its_node_was_shut_down_a_page_may_drive_again() -> None:
    async with driven() as (there, robot), there.client() as client:
        await entered(client)
        await command(client, 0.1)
        await until(lambda: robot.speeds)
        teleop = there.gateway.context.teleop
        assert teleop is not None
        assert teleop._graph is not None
        await teleop._graph.close()
        status = await client.wait("status")
        assert "the node was shut down" in status["message"]
        robot.commands.clear()
        await command(client, 0.0)
        # The command that starts the node again is published only if it is a stop.
        await until(lambda: robot.speeds)
        assert robot.speeds == [0.0]
        await command(client, 0.2)
        await until(lambda: robot.speeds[-1] > 0)


async def test_a_gateway_that_ends_stops_the_robot() -> None:
    async with driven() as (there, robot), there.client() as client:
        await entered(client)
        await command(client, 0.1)
        await until(lambda: robot.speeds)
        await there.gateway.close()
        assert robot.speeds[-1] == 0.0
        assert "/web_teleop" not in there.network.snapshot().nodes


# How long the robot may move, as the best of a few trials, because this machine may be busy.
STOP_LIMIT_S = 0.25
TRIALS = 5


async def stops_in_time(lose: Callable[[asyncio.subprocess.Process, Relay], None]) -> None:
    """Let another program drive, lose it, and measure how long the robot moves."""
    delays = []
    async with driven() as (there, robot):
        for _ in range(TRIALS):
            robot.commands.clear()
            async with Relay.to(there.gateway.port) as relay:
                process = await asyncio.create_subprocess_exec(
                    sys.executable, "-c", DRIVER, f"ws://127.0.0.1:{relay.port}"
                )
                try:
                    await until(lambda: 0.5 in robot.speeds)
                    lose(process, relay)
                    await until(lambda: robot.speeds[-1] == 0.0)
                finally:
                    with contextlib.suppress(ProcessLookupError):
                        process.kill()
                    await process.wait()
            delays.append(robot.stop_delay_s())
            if min(delays) < STOP_LIMIT_S:
                return
    raise AssertionError(f"the robot went on for {delays} s")


class Relay:
    """A network between a page and the gateway that can fail without closing connections."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._is_cut = False
        self._tasks: set[asyncio.Task[None]] = set()
        self._writers: list[asyncio.StreamWriter] = []
        self._server: asyncio.Server | None = None

    @property
    def port(self) -> int:
        assert self._server is not None
        return int(self._server.sockets[0].getsockname()[1])

    @classmethod
    @asynccontextmanager
    async def to(cls, port: int) -> AsyncIterator[Relay]:
        relay = cls(port)
        relay._server = await asyncio.start_server(relay._serve, "127.0.0.1", 0)
        try:
            yield relay
        finally:
            relay._server.close()
            for task in relay._tasks:
                task.cancel()
            await asyncio.gather(*relay._tasks, return_exceptions=True)
            for writer in relay._writers:
                writer.transport.abort()
                with contextlib.suppress(ConnectionError):
                    await writer.wait_closed()

    def cut(self) -> None:
        self._is_cut = True

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, here = await asyncio.open_connection("127.0.0.1", self._target)
        self._writers += [writer, here]
        for source, target in ((reader, here), (there, writer)):
            task = asyncio.ensure_future(self._copy(source, target))
            self._tasks.add(task)

    async def _copy(self, source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
        try:
            while data := await source.read(65536):
                if self._is_cut:
                    await asyncio.Event().wait()
                target.write(data)
        finally:
            if not self._is_cut:
                target.close()


async def test_the_robot_stops_when_its_page_is_killed() -> None:
    await stops_in_time(lambda process, _: process.kill())


async def test_the_robot_stops_when_its_page_freezes() -> None:
    await stops_in_time(lambda process, _: os.kill(process.pid, signal.SIGSTOP))


async def test_the_robot_stops_when_the_network_is_lost() -> None:
    await stops_in_time(lambda _, relay: relay.cut())
