"""Twenty robots on bad Wi-Fi, in this process; `rostether fleet` commands them from other processes."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import NamedTuple

from interop.lossy_network import LossyNetwork
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.platform.command_link import ReceiverSettings
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress
from unit.platform.datagrams import loopback_group, running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until

ROBOTS = 20
CONTROL = "arduino_control/ArduinoControl"
KIND = bytes.fromhex("7528cb4c")
KEY = bytes.fromhex("00112233445566778899aabbccddeeff")
ZERO_COMMAND = bytes(16)


class Robot:
    """The messages of one robot's topic, with their times."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.address = loopback_group()
        self.commands: list[tuple[bytes, float]] = []

    @property
    def is_stopped(self) -> bool:
        return self.commands[-1][0] == ZERO_COMMAND

    def settings(self) -> ReceiverNodeSettings:
        framed = ReceiverSettings(self.number, kind=KIND, key=KEY)
        return ReceiverNodeSettings(CONTROL, f"/robot{self.number}", self.address, (), framed, has_key=True)

    async def listen(self, graph: TypedGraph) -> None:
        def store(payloads: Sequence[bytes]) -> None:
            now_s = asyncio.get_running_loop().time()
            self.commands += [(each, now_s) for each in payloads]

        await graph.raw.subscribe(f"/robot{self.number}", ANY_MESSAGE, store)


class Fleet(NamedTuple):
    """The robots, the simulated Wi-Fi, the address for senders, and the options of `rostether fleet`
    for it.
    """

    robots: list[Robot]
    network: LossyNetwork
    senders: GroupAddress
    options: tuple[str, ...]


@asynccontextmanager
async def fleet_on_bad_wifi(folder: Path) -> AsyncIterator[Fleet]:
    """Run robots that lose 30 % of all datagrams and get the others up to 100 ms late."""
    key_file = folder / "fleet.key"
    key_file.write_text(KEY.hex())
    senders = loopback_group()
    options = ("--port", str(senders.port), "--interface", "lo", "--ttl", "0", "--key-file", str(key_file))
    _, (node, listener) = await typed_nodes("/receivers", "/listener")
    robots = [Robot(number) for number in range(1, ROBOTS + 1)]
    lines = Lines()
    for robot in robots:
        await robot.listen(listener)
    async with running(*[receive_topic(node, robot.settings(), lines) for robot in robots]):
        await until(lambda: len(lines.texts) == ROBOTS)
        with LossyNetwork(senders, [robot.address for robot in robots], loss=0.3, jitter_s=0.1) as network:
            yield Fleet(robots, network, senders, options)
