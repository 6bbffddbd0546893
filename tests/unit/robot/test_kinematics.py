from __future__ import annotations

import math

import pytest

from robot_poses import forward_kinematics
from rostether.errors import RobotModelError
from rostether.robot.kinematics import joint_transform, with_mimics
from rostether.robot.urdf import parse_urdf
from unit.robot.robots import ARM, GRIPPER, LIMIT, joint, robot

PLANE = robot(
    "plane",
    "base first second",
    joint("shoulder", "revolute", "base", "first", '<axis xyz="0 0 1"/>' + LIMIT)
    + joint("elbow", "revolute", "first", "second", '<origin xyz="2 0 0"/><axis xyz="0 0 2"/>' + LIMIT),
)


@pytest.mark.parametrize(("shoulder", "elbow"), [(0.0, 0.0), (0.5, 0.0), (0.3, -0.7), (2.0, 1.0)])
def test_a_planar_arm_is_where_geometry_predicts(shoulder: float, elbow: float) -> None:
    stands = forward_kinematics(parse_urdf(PLANE), {"shoulder": shoulder, "elbow": elbow})
    second = stands["second"]
    assert second.translation == pytest.approx((2 * math.cos(shoulder), 2 * math.sin(shoulder), 0.0))
    turn = (shoulder + elbow) / 2
    assert second.rotation == pytest.approx((0.0, 0.0, math.sin(turn), math.cos(turn)))


def test_a_prismatic_joint_moves_along_its_axis() -> None:
    lift = parse_urdf(GRIPPER).joints["lift"]
    rest, moved = joint_transform(lift), joint_transform(lift, 0.5)
    assert rest.translation == (0.1, 0.2, 0.3)
    expected = rest.apply((0.0, 0.3, 0.4))
    assert moved.translation == pytest.approx(expected)
    assert moved.rotation == rest.rotation


def test_a_fixed_joint_ignores_positions() -> None:
    wrist = parse_urdf(ARM).joints["wrist"]
    assert joint_transform(wrist, 1.0) == joint_transform(wrist)


def test_joints_follow_also_through_others() -> None:
    model = parse_urdf(GRIPPER)
    assert with_mimics(model, {"left": 1.0}) == {"left": 1.0, "right": -1.25, "tip": -2.5}
    assert with_mimics(model, {"right": 2.0})["tip"] == 4.0
    assert with_mimics(model, {}) == {"right": 0.25, "tip": 0.5}


def test_a_circle_of_mimics_is_refused() -> None:
    model = parse_urdf(
        robot(
            "x",
            "a b c",
            joint("j", "continuous", "a", "b", '<mimic joint="k"/>')
            + joint("k", "continuous", "b", "c", '<mimic joint="j"/>'),
        )
    )
    with pytest.raises(RobotModelError, match="circle: j, k, j"):
        with_mimics(model, {})
