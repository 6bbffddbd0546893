"""The MeArm example with Debian's ROS 1: its launch file, nodes, services and the model's frames."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from interop.mearm_workspace import show_packages
from interop.ros1_peers import Ros1Peers
from programs import Peer

SELECT = ("rosservice", "call", "/select_position_set")
POSE = ("rosservice", "call", "/set_servo_pose")
SERVICE_LAUNCH = ("roslaunch", "mearm_model", "service.launch", "rviz:=false")


@pytest.fixture
def mearm(roscore: Ros1Peers, tmp_path: Path) -> Ros1Peers:
    show_packages(roscore, tmp_path / "catkin_ws")
    return roscore


async def wait_for_services(peers: Ros1Peers, *services: str) -> None:
    """Wait until nodes offer the services."""
    while not set(services) <= set((await peers.run("rosservice", "list")).split()):
        await asyncio.sleep(0.1)


async def servo_angles(peers: Ros1Peers, count: int = 1) -> list[tuple[int, ...]]:
    """Return the next messages on /servo_pose_server."""
    text = await peers.run("rostopic", "echo", "-n", str(count), "/servo_pose_server")
    return [tuple(map(int, re.findall(r"servo\d: (-?\d+)", each))) for each in text.split("---")[:count]]


async def wait_for_servo_angles(peers: Ros1Peers, expected: Sequence[int]) -> None:
    """Wait until the controller sends the servos these angles."""
    async with asyncio.timeout(60):
        while (await servo_angles(peers))[0] != tuple(expected):
            pass


async def test_services_move_servos_and_model(mearm: Ros1Peers) -> None:
    launched = await mearm.start(*SERVICE_LAUNCH)
    await wait_for_services(mearm, "/select_position_set", "/set_servo_pose")
    await check_refused_position_sets(mearm, launched)
    await check_pose(mearm)
    await check_position_set(mearm)
    await check_model(mearm)


async def check_refused_position_sets(mearm: Ros1Peers, launched: Peer) -> None:
    assert await servo_angles(mearm) == [(0, 0, 0, 0)]
    assert await mearm.run(*SELECT, "set_name: 'set2'") == "success: False"
    await launched.wait_for("Position set set2 is refused: it has 3 values, but the arm has 4 joints")
    assert await mearm.run(*SELECT, "set_name: 'wave'") == "success: False"
    await launched.wait_for("Position set wave not found; there are: set1, set2, set3")
    await mearm.run("rosparam", "set", "/position_sets/odd", "[0.1, .nan, 0.3, yes]")
    assert await mearm.run(*SELECT, "set_name: 'odd'") == "success: False"
    assert await servo_angles(mearm) == [(0, 0, 0, 0)]


async def check_pose(mearm: Ros1Peers) -> None:
    listening = await mearm.start("rostopic", "echo", "-p", "/servo_pose_server")
    await listening.wait_for(",0,0,0,0")
    assert await mearm.run(*POSE, "position_id: 1") == "success: True"
    await listening.wait_for(lambda lines: sum(line.endswith(",45,120,60,10") for line in lines) > 2)
    rows = [line.split(",")[1:] for line in listening.lines[1:]]
    shoulder = [int(row[1]) for row in rows]
    assert shoulder == sorted(shoulder)
    assert {12, 24, 36, 48, 60, 72, 84, 96, 108, 120} <= set(shoulder)
    assert await mearm.run(*SELECT, "set_name: 'set1'") == "success: True"
    await wait_for_servo_angles(mearm, (0, 29, -29, 14))
    for unknown in ("3", "-1"):
        assert await mearm.run(*POSE, f"position_id: {unknown}") == "success: False"


async def check_position_set(mearm: Ros1Peers) -> None:
    assert await mearm.run(*SELECT, "set_name: 'set3'") == "success: True"
    await wait_for_servo_angles(mearm, (-14, 0, 14, 29))
    states = await mearm.run("rostopic", "echo", "-n", "1", "/joint_states")
    assert "position: [-0.25, 0.0, 0.25, 0.5]" in states


async def check_model(mearm: Ros1Peers) -> None:
    tree = await mearm.start("rostopic", "echo", "/tf_static")
    await tree.wait_for('child_frame_id: "claw"')
    moving = await mearm.start("rostopic", "echo", "/tf")
    for link in ("turret", "upper_arm", "forearm", "finger"):
        await moving.wait_for(f'child_frame_id: "{link}"')
