"""`rostether topic` compared with rostopic on one graph, with Debian's master and with rostether's."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from interop.ros1_peers import Ros1Peers, debian_roscore
from programs import ROSTETHER, Peer

NODE = """
import rospy
from sensor_msgs.msg import LaserScan, Range
from std_msgs.msg import Empty, String, UInt8MultiArray

rospy.init_node("stage")
name = rospy.Publisher("/name", String, latch=True, queue_size=1)
name.publish('grüße: "5"')
scan = rospy.Publisher("/scan", LaserScan, latch=True, queue_size=1)
message = LaserScan(ranges=[1.0, 0.1, float("inf")], angle_max=0.1)
message.header.stamp = rospy.Time(7, 5)
message.header.frame_id = "laser"
scan.publish(message)
data = rospy.Publisher("/data", UInt8MultiArray, latch=True, queue_size=1)
data.publish(UInt8MultiArray(data=[1, 2, 255]))
rospy.Subscriber("/toggle_led", Empty, lambda m: None)
rospy.Subscriber("/scan", LaserScan, lambda m: None)
ticks = rospy.Publisher("/ticks", Range, queue_size=10)
print("ready", flush=True)
rate = rospy.Rate(20)
while not rospy.is_shutdown():
    ticks.publish(Range(range=1.5))
    rate.sleep()
"""


@asynccontextmanager
async def rostether_master(home: Path) -> AsyncIterator[Ros1Peers]:
    peers = Ros1Peers("http://localhost:1/", home)
    try:
        core = await peers.start(*ROSTETHER, "core", "--port", "0")
        await core.wait_for("ROS_MASTER_URI=")
        uri = next(line for line in core.lines if "ROS_MASTER_URI=" in line).partition("=")[2]
        peers.master_uri = peers.environment["ROS_MASTER_URI"] = uri
        yield peers
    finally:
        await peers.close()


@pytest.fixture(params=["debian", "rostether"])
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Ros1Peers]:
    """A graph with a rospy node that publishes and subscribes."""
    graph = debian_roscore(tmp_path) if request.param == "debian" else rostether_master(tmp_path)
    async with graph as peers:
        await (await peers.rospy(NODE)).wait_for("ready")
        yield peers


@pytest.mark.parametrize("stage", ["debian"], indirect=True)
async def test_listings_equal_those_of_rostopic(stage: Ros1Peers) -> None:
    commands = [
        "topic list",
        "topic list -v",
        "topic list -p",
        "topic list -s",
        "topic list /scan",
        "topic info /scan",
        "topic info /toggle_led",
        "topic type /scan",
        "topic type /scan/header/stamp",
        "topic find std_msgs/String",
    ]
    slots = asyncio.Semaphore(3)

    async def compare(command: str) -> str:
        group, *rest = command.split()
        async with slots:
            rostether = await stage.run(*ROSTETHER, group, *rest)
            debian = await stage.run(f"ros{group}", *rest)
        # Debian's -v lists topics in the order of their registration, rostether's by name.
        same = (
            sorted(rostether.splitlines()) == sorted(debian.splitlines())
            if "-v" in rest
            else rostether == debian
        )
        return "" if same else f"--- {command}\n{debian}\n--- and rostether\n{rostether}"

    differences = [text for text in await asyncio.gather(*map(compare, commands)) if text]
    assert not differences, "\n".join(differences)


def without_sequence_number(text: str) -> str:
    """Replace the sequence number, which rospy increments for each new subscriber of a latched topic."""
    return re.sub(r"(seq: +|^7000000005,)\d+", r"\1N", text, flags=re.MULTILINE)


async def test_echo_equals_that_of_rostopic(stage: Ros1Peers) -> None:
    commands = [
        "/name",
        "/scan",
        "--noarr /scan",
        "--nostr /scan",
        "-p /scan",
        "/scan/ranges[1:]",
        "/scan/header/stamp",
        "-w 6 /scan",
        "/data",
    ]
    slots = asyncio.Semaphore(3)

    async def compare(command: str) -> str:
        async with slots:
            rostether = await stage.run(*ROSTETHER, "topic", "echo", "-n", "1", *command.split())
            debian = await stage.run("rostopic", "echo", "-n", "1", *command.split())
        same = without_sequence_number(rostether) == without_sequence_number(debian)
        return "" if same else f"--- {command}\n{debian}\n--- and rostether\n{rostether}"

    differences = [text for text in await asyncio.gather(*map(compare, commands)) if text]
    assert not differences, "\n".join(differences)


@pytest.mark.parametrize("stage", ["debian"], indirect=True)
async def test_rates_have_the_format_of_rostopic(stage: Ros1Peers) -> None:
    for verb in ("hz", "bw"):
        for _ in range(10):
            debian = await stage.start("rostopic", verb, "/ticks")
            rostether = await stage.start(*ROSTETHER, "topic", verb, "-n", "1", "/ticks")
            await debian.wait_for(lambda lines: len(lines) >= 3)
            await debian.stop()
            await rostether.finish()
            # On a busy machine, either may measure before enough messages have arrived.
            if not any("no new messages" in peer.text or len(peer.lines) < 3 for peer in (debian, rostether)):
                break
        forms = [
            [
                re.sub(r"\d+(\.\d+)?", lambda n: "0." + "0" * len((n[1] or ".")[1:]), line)
                for line in peer.lines[:3]
            ]
            for peer in (debian, rostether)
        ]
        assert forms[0] == forms[1]


@pytest.mark.parametrize("stage", ["rostether"], indirect=True)
async def test_messages_are_exchanged_with_rostopic(stage: Ros1Peers) -> None:
    async def publish_until_received(echo: Peer, *command: str) -> str:
        """Publish for three seconds, and repeat it if that was too short for the echo on a busy machine."""
        await echo.wait_for("does not appear to be published yet")
        for _ in range(10):
            printed = await stage.run(*command)
            if echo.process.returncode is not None:
                break
        return printed

    debian = await stage.start("rostopic", "echo", "-n", "1", "/out")
    arguments = ("pub", "-1", "/out", "std_msgs/String", "data: from rostether")
    rostether = await publish_until_received(debian, *ROSTETHER, "topic", *arguments)
    assert rostether == "publishing and latching message for 3.0 seconds"
    assert 'data: "from rostether"' in await debian.finish()
    echoing = await stage.start(*ROSTETHER, "topic", "echo", "-n", "1", "/in")
    arguments = ("pub", "-1", "/in", "std_msgs/String", "data: from Debian")
    assert await publish_until_received(echoing, "rostopic", *arguments) == rostether
    assert 'data: "from Debian"' in await echoing.finish()
