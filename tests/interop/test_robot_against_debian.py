"""Compares robot_state_publisher, joint_state_publisher and static_transform_publisher with Debian's."""

from __future__ import annotations

import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from interop.robot_stage import RobotStage
from interop.ros1_peers import Ros1Peers
from robot_poses import forward_kinematics
from rostether.robot.robot_state import with_mimics
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.transform import StampedTransform, Transform
from rostether.robot.urdf import parse_urdf
from unit.robot.robots import GRIPPER, ROBOTS

pytestmark = pytest.mark.robot

TOLERANCE = 1e-9
SECOND = 10**9
START_NS = 1_700_000_000 * SECOND
SOURCE = "/arm_states"
SIDES = ("debian", "rostether")

MOVED = {
    "arm": ["j0", "j1", "j2"],
    "gripper": ["lift", "left"],
    "rover": ["wheel_left", "wheel_right", "mast", "sled", "drone", "root"],
}


def assert_same_transforms(rostether: list[Any], debian: list[Any], *, with_stamps: bool) -> None:
    assert [each[:2] for each in rostether] == [each[:2] for each in debian]
    for found, expected in zip(rostether, debian, strict=True):
        if with_stamps:
            assert found[2] == expected[2]
        assert found[3] == pytest.approx(expected[3], abs=TOLERANCE)
        assert found[4] == pytest.approx(expected[4], abs=TOLERANCE)


def states_of(robot: str) -> list[tuple[int, list[str], list[float], bool]]:
    """Return joint states, and whether each one is late enough to be published."""
    rng = random.Random(robot)
    states = []
    stamp_ns = START_NS
    for number in range(25):
        names = MOVED[robot] if number % 5 else MOVED[robot][:1]
        is_early = number % 7 == 3
        stamp_ns += 4_000_000 if is_early else 100_000_000
        states.append((stamp_ns, names, [rng.uniform(-7, 7) for _ in names], not is_early))
    return states


async def robot_states(roscore: Ros1Peers, robot: str, side: str, *arguments: str) -> dict[str, list[Any]]:
    stage = RobotStage(roscore)
    await stage.set_params({"/robot_description": ROBOTS[robot]})
    await stage.start_recorder()
    node = await stage.start_node(side, "robot_state_publisher", f"__name:=rsp_{side}", *arguments)
    await stage.wait_for_subscribers(1)
    await stage.wait_for(lambda records: any(each["topic"] == "/tf_static" for each in records))
    for stamp_ns, names, positions, is_due in states_of(robot):
        stage.publish(stamp_ns, names, positions)
        if is_due:
            await stage.wait_for(
                lambda records, stamp_ns=stamp_ns: any(  # type: ignore[misc]
                    each[2] == stamp_ns for record in records for each in record["transforms"]
                )
            )
    await node.stop()
    await stage.stop_recorder()
    found: dict[str, list[Any]] = {"/tf": [], "/tf_static": []}
    for record in stage.records:
        found[record["topic"]] += record["transforms"]
    return found


@pytest.mark.parametrize("robot", ROBOTS)
async def test_robot_state_publisher_publishes_the_same_as_debians(roscore: Ros1Peers, robot: str) -> None:
    debian = await robot_states(roscore, robot, "debian")
    rostether = await robot_states(roscore, robot, "rostether", "__ns:=/")
    if robot == "gripper":
        # Debian's handles a mimic joint of a mimic joint only if their names are in the right order.
        assert {each[1] for each in debian["/tf"]} == {each[1] for each in rostether["/tf"]}
    assert_same_transforms(rostether["/tf"], debian["/tf"], with_stamps=True)
    assert_same_transforms(rostether["/tf_static"], debian["/tf_static"], with_stamps=False)
    assert len(rostether["/tf"]) > 30
    compare_with_kinematics(robot, rostether)


def compare_with_kinematics(robot: str, found: dict[str, list[Any]]) -> None:
    model = parse_urdf(ROBOTS[robot])
    complete_states = [each for each in states_of(robot) if each[3] and each[1] == MOVED[robot]]
    stamp_ns, names, positions, _ = complete_states[-1]
    buffer = TransformBuffer()
    for topic in ("/tf_static", "/tf"):
        for parent, child, stamp_ns, translation, rotation in found[topic]:
            stamped = StampedTransform(
                parent, child, stamp_ns, Transform(tuple(translation), tuple(rotation))
            )
            assert not buffer.set_transform(stamped, is_static=topic == "/tf_static")
    reported = dict(zip(names, positions, strict=True))
    poses = forward_kinematics(model, with_mimics(model, reported))
    compared = 0
    for link, expected in poses.items():
        if link in buffer.frames and link != model.root:
            seen = buffer.lookup(model.root, link, 0 if link in ("body", "sled") else stamp_ns).transform
            assert seen.translation == pytest.approx(expected.translation, abs=TOLERANCE)
            assert same_rotation(seen, expected)
            compared += 1
    assert compared >= 4


def same_rotation(one: Transform, other: Transform) -> bool:
    dot = sum(a * b for a, b in zip(one.rotation, other.rotation, strict=True))
    return abs(abs(dot) - 1.0) < TOLERANCE


async def test_prefix_and_fixed_transforms_on_tf(roscore: Ros1Peers) -> None:
    seen = {}
    for side in SIDES:
        stage = RobotStage(roscore)
        await stage.set_params({"/robot_description": ROBOTS["rover"], "/tf_prefix": "/r1"})
        await stage.start_recorder()
        node = await stage.start_node(
            side, "robot_state_publisher", f"__name:=rsp_{side}", "_use_tf_static:=false"
        )
        await stage.wait_for(lambda records: len(records) > 3)
        seen[side] = stage.records[0]["transforms"]
        await node.stop()
        await stage.stop_recorder()
    assert_same_transforms(seen["rostether"], seen["debian"], with_stamps=False)
    assert seen["rostether"][0][:2] == ["r1/foot", "r1/body"]


JOINT_CASES: dict[str, dict[str, Any]] = {
    "arm": {},
    "gripper": {},
    "rover": {},
    "gripper without soft limits": {"use_smallest_joint_limits": False},
    "gripper without mimics": {"use_mimic_tags": False},
    "arm with zeros": {"zeros": {"j0": 0.5, "j2": -1}},
    "arm that depends": {"dependent_joints": {"j1": {"parent": "j0", "factor": 2, "offset": 0.5}}},
    "arm with all": {"publish_default_velocities": True, "publish_default_efforts": True},
    "arm without positions": {"publish_default_positions": False},
}


async def joint_states(
    roscore: Ros1Peers, side: str, robot: str, parameters: Mapping[str, Any], *, has_source: bool = False
) -> tuple[dict[str, Any], dict[str, Any]]:
    stage = RobotStage(roscore)
    name = f"jsp_{side}"
    node_parameters = {f"/{name}/{key}": value for key, value in parameters.items()}
    if has_source:
        node_parameters[f"/{name}/source_list"] = [SOURCE]
    await stage.set_params({"/robot_description": ROBOTS[robot], f"/{name}/rate": 50, **node_parameters})
    await stage.start_recorder(SOURCE)
    node = await stage.start_node(
        side, "joint_state_publisher", f"__name:={name}", "joint_states:=joint_states_out"
    )
    await stage.wait_for(lambda records: len(records) > 2)
    before = stage.records[-1]
    if has_source:
        await stage.wait_for_subscribers(1)
        stage.publish(START_NS, [*MOVED[robot], "strange"], [*(0.07 for _ in MOVED[robot]), 3.0])
        await stage.wait_for(lambda records: 0.07 in records[-1]["position"])
    after = stage.records[-1]
    await node.stop()
    await stage.stop_recorder()
    for record in (before, after):
        del record["node"]
    return before, after


@pytest.mark.parametrize("case", JOINT_CASES)
async def test_joint_state_publisher_publishes_the_same_as_debians(roscore: Ros1Peers, case: str) -> None:
    robot = case.split()[0]
    debian, _ = await joint_states(roscore, "debian", robot, JOINT_CASES[case])
    rostether, _ = await joint_states(roscore, "rostether", robot, JOINT_CASES[case])
    assert rostether["name"] == debian["name"] != []
    for field in ("position", "velocity", "effort"):
        assert rostether[field] == pytest.approx(debian[field], abs=TOLERANCE)


async def test_joint_state_publisher_uses_sources(roscore: Ros1Peers) -> None:
    _, debian = await joint_states(roscore, "debian", "gripper", {}, has_source=True)
    _, rostether = await joint_states(roscore, "rostether", "gripper", {}, has_source=True)
    assert rostether["name"] == debian["name"]
    assert rostether["position"] == pytest.approx(debian["position"], abs=TOLERANCE)


@pytest.mark.parametrize(
    "arguments",
    [
        ["0.1", "-0.2", "0.3", "0.4", "-0.5", "0.6", "world", "laser"],
        ["1", "2", "3", "0.5", "-0.5", "0.5", "0.5", "world", "laser"],
    ],
)
async def test_static_transform_publisher_publishes_the_same_as_debians(
    roscore: Ros1Peers, arguments: list[str]
) -> None:
    seen = {}
    for side in SIDES:
        stage = RobotStage(roscore)
        await stage.start_recorder()
        node = await stage.start_node(side, "tf2_ros", *arguments, f"__name:=static_{side}")
        await stage.wait_for(lambda records: bool(records))
        seen[side] = stage.records[0]["transforms"]
        await node.stop()
        await stage.stop_recorder()
    assert_same_transforms(seen["rostether"], seen["debian"], with_stamps=False)


@pytest.mark.parametrize("robot", ROBOTS)
async def test_urdf_check_prints_the_same_as_check_urdf(
    roscore: Ros1Peers, robot: str, tmp_path: Path
) -> None:
    import sys

    file = tmp_path / "robot.urdf"
    file.write_text(ROBOTS[robot])
    debian = await roscore.run("check_urdf", str(file))
    rostether = await roscore.run(sys.executable, "-P", "-m", "rostether", "urdf", "check", str(file))
    assert rostether == debian


def test_the_gripper_has_a_chain_of_mimics() -> None:
    model = parse_urdf(GRIPPER)
    assert with_mimics(model, {"left": 1.0})["tip"] == pytest.approx(2 * (-1.5 + 0.25))
