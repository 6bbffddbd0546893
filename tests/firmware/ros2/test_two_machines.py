"""A board on one machine and a ROS 2 node on another, each with a zenoh router, even when one router
restarts.

The machines are network namespaces, the board runs real firmware, the node is zenoh-ros2-sdk.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
import pytest_asyncio

from firmware.ros2.serving import SKETCHES, serving, sim_address
from interop.machines import Machines, machines, missing_namespaces
from interop.zenoh_peers import SdkPeer, missing_sdk, sdk_peer
from programs import Peer, start_command
from waiting import until

pytestmark = [
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.timeout(300),
    pytest.mark.skipif(bool(missing_sdk()), reason=missing_sdk()),
    pytest.mark.skipif(bool(missing_namespaces()), reason=missing_namespaces()),
]

TIMEOUT_S = 60.0
ROUTER_PORT = 7447
UINT32 = {"msg_type": "std_msgs/msg/UInt32", "msg_definition": "uint32 data\n"}
SET_BOOL_DEFINITIONS = {
    "request_definition": "bool data",
    "response_definition": "bool success\nstring message",
}
DEFAULT_SETTINGS = {"ROS_DOMAIN_ID": "0", "ZENOH_CONFIG_OVERRIDE": "", "ZENOH_SESSION_CONFIG_URI": ""}


class Router:
    """The router of a machine, which can be restarted."""

    def __init__(self, on: tuple[str, ...], *options: str) -> None:
        self._on = on
        self._options = options
        self._process: Peer | None = None

    async def start(self) -> None:
        """Start it, and wait until it routes."""
        command = ("core", "--ros2", "zenoh", *self._options)
        self._process = await start_command(*command, environment=DEFAULT_SETTINGS, on=self._on)
        await self._process.wait_for("Press Ctrl-C", TIMEOUT_S)

    async def stop(self) -> None:
        """Kill it, like a power failure."""
        if self._process is not None:
            self._process.process.kill()
            await self._process.stop()


class Fleet:
    """`robot` with a board, `laptop` with a node of zenoh-ros2-sdk."""

    def __init__(self, routers: dict[str, Router], node: SdkPeer) -> None:
        self.routers = routers
        self.node = node
        self._sent = 0

    def numbers(self, topic: str) -> list[int]:
        """Return the numbers that the node has received on a topic."""
        return [fields["data"] for fields in self.node.received_on.get(topic, [])]

    async def wait_for_messages(self) -> None:
        """Wait until messages pass in both directions; from then on, nothing may be missing."""
        received = len(self.numbers("/count"))
        await until(lambda: len(self.numbers("/count")) > received, "the count")
        for _ in range(100):
            self._sent += 1
            await self.node.do("publish", "/say", messages=[{"data": self._sent}])
            await asyncio.sleep(0.05)
            if self._sent in self.numbers("/repeated"):
                return
        raise AssertionError("the board receives nothing")

    async def wait_for_silence(self) -> int:
        """Wait until nothing arrives any more; return the number of counts received."""
        received = -1
        while len(self.numbers("/count")) != received:
            received = len(self.numbers("/count"))
            await asyncio.sleep(0.3)
        return received

    async def require_all(self, count: int) -> None:
        """Check that `count` messages pass in both directions, each once and in order."""
        counted, repeated = len(self.numbers("/count")), len(self.numbers("/repeated"))
        sent = list(range(self._sent + 1, self._sent + count + 1))
        self._sent += count
        for number in sent:
            await self.node.do("publish", "/say", messages=[{"data": number}])
            # An Uno can store 64 bytes while it waits for its line.
            await asyncio.sleep(0.01)
        await until(lambda: len(self.numbers("/repeated")) >= repeated + count, "the last one")
        await until(lambda: len(self.numbers("/count")) >= counted + count, "the count")
        assert self.numbers("/repeated")[repeated:] == sent
        numbers = self.numbers("/count")[counted:]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        everything = self.numbers("/count")
        assert everything == sorted(set(everything))

    async def call(self) -> bool:
        """Call the board's service."""
        answered = await self.node.do(
            "call", "/switch", srv_type="std_srvs/srv/SetBool", request={"data": True}, **SET_BOOL_DEFINITIONS
        )
        return answered["response"] is not None and bool(answered["response"]["success"])


@pytest.fixture(scope="module")
def network() -> Iterator[Machines]:
    with machines("robot", "laptop") as network:
        yield network


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def fleet(network: Machines, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Fleet]:
    home: Path = tmp_path_factory.mktemp("home")
    robot, laptop = network.on("robot"), network.on("laptop")
    routers = {
        "robot": Router(robot, "--zenoh-listen", f"tcp/0.0.0.0:{ROUTER_PORT}"),
        "laptop": Router(laptop, "--zenoh-connect", f"tcp/{network.address('robot')}:{ROUTER_PORT}"),
    }
    board = await sim_address(SKETCHES / "Counter", "uno", "arm")
    async with AsyncExitStack() as stack:
        for router in routers.values():
            stack.push_async_callback(router.stop)
            await router.start()
        await stack.enter_async_context(
            serving("--ros2", "zenoh", board, environment=DEFAULT_SETTINGS, on=robot)
        )
        node = await stack.enter_async_context(sdk_peer(ROUTER_PORT, home, on=laptop))
        await node.do("subscribe", "/count", **UINT32)
        await node.do("subscribe", "/repeated", **UINT32)
        await node.do("advertise", "/say", **UINT32)
        yield Fleet(routers, node)


async def test_a_board_and_a_node_exchange_messages(fleet: Fleet) -> None:
    await fleet.wait_for_messages()
    await fleet.require_all(50)
    assert await fleet.call()


@pytest.mark.parametrize("name", ["robot", "laptop"])
async def test_a_router_restarts(fleet: Fleet, name: str) -> None:
    await fleet.wait_for_messages()
    await fleet.routers[name].stop()
    received = await fleet.wait_for_silence()
    await fleet.routers[name].start()
    await until(lambda: len(fleet.numbers("/count")) > received, "the count again")
    await fleet.wait_for_messages()
    await fleet.require_all(50)
    assert await fleet.call()
