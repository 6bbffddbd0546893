"""`rostether topic` compared with rostopic on one graph, with Debian's master and with rostether's."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from interop.ros1_peers import Ros1Peers, debian_roscore
from programs import Peer

ROSTETHER = (sys.executable, "-m", "rostether")

STAGE = """
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
async def our_master(home: Path) -> AsyncIterator[Ros1Peers]:
    peers = Ros1Peers("http://localhost:1/", home)
    try:
        core = await peers.start(*ROSTETHER, "core", "--port", "0")
        await core.wait_for("ROS_MASTER_URI=")
        uri = next(line for line in core.lines if "ROS_MASTER_URI=" in line).partition("=")[2]
        peers.master_uri = peers.environment["ROS_MASTER_URI"] = uri
        yield peers
    finally:
        await peers.close()


@pytest.fixture(params=["debian", "ours"])
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Ros1Peers]:
    """A graph with a rospy node that publishes and subscribes."""
    graph = debian_roscore(tmp_path) if request.param == "debian" else our_master(tmp_path)
    async with graph as peers:
        await (await peers.rospy(STAGE)).wait_for("ready")
        yield peers


@pytest.mark.parametrize("stage", ["debian"], indirect=True)
async def test_listings_are_debian_s(stage: Ros1Peers) -> None:
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
    gate = asyncio.Semaphore(3)

    async def compare(command: str) -> str:
        group, *rest = command.split()
        async with gate:
            ours = await stage.run(*ROSTETHER, group, *rest)
            theirs = await stage.run(f"ros{group}", *rest)
        # Debian's -v lists topics in the order of their registration, rostether's by name.
        same = sorted(ours.splitlines()) == sorted(theirs.splitlines()) if "-v" in rest else ours == theirs
        return "" if same else f"--- {command}\n{theirs}\n--- and ours\n{ours}"

    differences = [text for text in await asyncio.gather(*map(compare, commands)) if text]
    assert not differences, "\n".join(differences)


def blur_seq(text: str) -> str:
    """Replace the sequence number, which rospy increments for each new subscriber of a latched topic."""
    return re.sub(r"(seq: +|^7000000005,)\d+", r"\1N", text, flags=re.MULTILINE)


async def test_echo_is_debian_s(stage: Ros1Peers) -> None:
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
    gate = asyncio.Semaphore(3)

    async def compare(command: str) -> str:
        async with gate:
            ours = await stage.run(*ROSTETHER, "topic", "echo", "-n", "1", *command.split())
            theirs = await stage.run("rostopic", "echo", "-n", "1", *command.split())
        same = blur_seq(ours) == blur_seq(theirs)
        return "" if same else f"--- {command}\n{theirs}\n--- and ours\n{ours}"

    differences = [text for text in await asyncio.gather(*map(compare, commands)) if text]
    assert not differences, "\n".join(differences)


@pytest.mark.parametrize("stage", ["debian"], indirect=True)
async def test_rates_read_as_debian_s(stage: Ros1Peers) -> None:
    for verb in ("hz", "bw"):
        for _ in range(10):
            theirs = await stage.start("rostopic", verb, "/ticks")
            ours = await stage.start(*ROSTETHER, "topic", verb, "-n", "1", "/ticks")
            await theirs.wait_for(lambda lines: len(lines) >= 3)
            await theirs.stop()
            await ours.finish()
            # On a busy machine, either may measure before enough messages have arrived.
            if not any("no new messages" in peer.text or len(peer.lines) < 3 for peer in (theirs, ours)):
                break
        forms = [
            [
                re.sub(r"\d+(\.\d+)?", lambda n: "0." + "0" * len((n[1] or ".")[1:]), line)
                for line in peer.lines[:3]
            ]
            for peer in (theirs, ours)
        ]
        assert forms[0] == forms[1]


@pytest.mark.parametrize("stage", ["ours"], indirect=True)
async def test_publishing_both_ways(stage: Ros1Peers) -> None:
    async def published(echo: Peer, *command: str) -> str:
        """Publish for three seconds, and repeat it if that was too short for the echo on a busy machine."""
        await echo.wait_for("does not appear to be published yet")
        for _ in range(10):
            printed = await stage.run(*command)
            if echo.process.returncode is not None:
                break
        return printed

    theirs = await stage.start("rostopic", "echo", "-n", "1", "/out")
    words = ("pub", "-1", "/out", "std_msgs/String", "data: from us")
    ours = await published(theirs, *ROSTETHER, "topic", *words)
    assert ours == "publishing and latching message for 3.0 seconds"
    assert 'data: "from us"' in await theirs.finish()
    echoing = await stage.start(*ROSTETHER, "topic", "echo", "-n", "1", "/in")
    words = ("pub", "-1", "/in", "std_msgs/String", "data: from them")
    assert await published(echoing, "rostopic", *words) == ours
    assert 'data: "from them"' in await echoing.finish()
