from __future__ import annotations

import math

import pytest

from robot_poses import forward_kinematics
from rostether.errors import RobotModelError
from rostether.robot.robot_state import RobotState, RobotStateSettings, joint_transform, prefixed, with_mimics
from rostether.robot.urdf import parse_urdf
from unit.robot.robots import ARM, GRIPPER, LIMIT, ROVER, joint, robot

SECOND = 10**9
NOW = 1_000 * SECOND
INTERVAL = SECOND // 50


PLANE = robot(
    "plane",
    "base first second",
    joint("shoulder", "revolute", "base", "first", '<axis xyz="0 0 1"/>' + LIMIT)
    + joint("elbow", "revolute", "first", "second", '<origin xyz="2 0 0"/><axis xyz="0 0 2"/>' + LIMIT),
)


def children(state: RobotState, names: list[str], stamp_ns: int, now_ns: int = NOW) -> list[str]:
    found = state.moving_transforms(names, [0.5] * len(names), stamp_ns, now_ns)
    return [each.child for each in found]


def test_fixed_joints_are_separate_from_moving_ones() -> None:
    model = parse_urdf(ROVER)
    state = RobotState(model)
    assert [each.child for each in state.fixed_transforms(NOW)] == ["body", "sled"]
    assert children(state, ["wheel_left", "mast", "sled", "drone"], NOW) == ["mast", "wheel_l"]


def test_positions_become_transforms() -> None:
    model = parse_urdf(ARM)
    found = RobotState(model).moving_transforms(["j2", "j0"], [0.3, 0.4], NOW, NOW)
    assert [each.child for each in found] == ["turret", "fore"]
    assert found[0].transform == joint_transform(model.joints["j0"], 0.4)
    assert found[1].transform == joint_transform(model.joints["j2"], 0.3)
    assert {each.stamp_ns for each in found} == {NOW}


def test_mimicking_joints_are_added_if_their_leader_is_known() -> None:
    state = RobotState(parse_urdf(GRIPPER))
    assert children(state, ["left"], NOW) == ["left", "right", "tip"]
    assert children(state, ["lift"], NOW + 2 * INTERVAL, NOW + SECOND) == ["slide"]


def test_states_that_arrive_too_early_are_skipped() -> None:
    state = RobotState(parse_urdf(ARM))
    assert children(state, ["j0"], NOW) == ["turret"]
    assert children(state, ["j0"], NOW + INTERVAL - 1, NOW + 1) == []
    assert children(state, ["j0"], NOW + INTERVAL, NOW + 2) == ["turret"]
    # A joint that has not been published yet is due immediately.
    assert children(state, ["j0", "j1"], NOW + INTERVAL + 1, NOW + 3) == ["turret", "upper"]


def test_timestamps_may_be_ignored() -> None:
    state = RobotState(parse_urdf(ARM), RobotStateSettings(ignore_timestamp=True))
    assert children(state, ["j0"], NOW) == ["turret"]
    assert children(state, ["j0"], NOW) == ["turret"]


def test_all_joints_are_published_again_after_a_reset_of_the_clock() -> None:
    state = RobotState(parse_urdf(ARM))
    assert children(state, ["j0"], NOW) == ["turret"]
    assert children(state, ["j0"], SECOND, 2 * SECOND) == ["turret"]
    assert "backwards" in state.problem


@pytest.mark.parametrize(
    ("names", "positions", "reported"),
    [
        (["j0", "j1"], [0.0], "2 names and 1 positions"),
        (["j0"], [], "without positions"),
        (["j9"], [0.0], "'j9', which the robot does not have"),
    ],
)
def test_problems_of_a_state_are_reported(names: list[str], positions: list[float], reported: str) -> None:
    state = RobotState(parse_urdf(ARM))
    assert state.moving_transforms(names, positions, NOW, NOW) == []
    assert reported in state.problem


def test_an_old_state_is_published_and_reported() -> None:
    state = RobotState(parse_urdf(ARM))
    assert children(state, ["j0"], NOW - 31 * SECOND) == ["turret"]
    assert "31.000 s old" in state.problem
    assert children(state, ["j0"], NOW) == ["turret"]
    assert state.problem == ""


def test_the_first_value_of_a_repeated_joint_counts() -> None:
    model = parse_urdf(ARM)
    found = RobotState(model).moving_transforms(["j0", "j0"], [0.1, 0.2], NOW, NOW)
    assert found[0].transform == joint_transform(model.joints["j0"], 0.1)


@pytest.mark.parametrize(
    ("prefix", "frame", "name"),
    [("", "a", "a"), ("r1", "a", "r1/a"), ("/r1", "a", "r1/a"), ("r1", "/a", "a")],
)
def test_frames_with_a_prefix(prefix: str, frame: str, name: str) -> None:
    assert prefixed(prefix, frame) == name


@pytest.mark.parametrize("position", [math.nan, math.inf, -math.inf])
def test_a_position_that_is_not_a_number_is_skipped(position: float) -> None:
    state = RobotState(parse_urdf(ARM))
    found = state.moving_transforms(["j0", "j1"], [position, 0.1], NOW, NOW)
    assert [each.child for each in found] == ["upper"]
    assert "ignored joint 'j0' in" in state.problem


def test_a_cycle_of_mimics_is_refused_before_the_first_state() -> None:
    text = robot(
        "x",
        "a b c",
        joint("j", "continuous", "a", "b", '<mimic joint="k"/>')
        + joint("k", "continuous", "b", "c", '<mimic joint="j"/>'),
    )
    with pytest.raises(RobotModelError, match="cycle"):
        RobotState(parse_urdf(text))


def test_unknown_names_are_not_stored() -> None:
    state = RobotState(parse_urdf(ARM))
    for number in range(100):
        state.moving_transforms([f"x{number}"], [0.0], NOW, NOW)
    assert state._published_ns == {}


@pytest.mark.parametrize(("shoulder", "elbow"), [(0.0, 0.0), (0.5, 0.0), (0.3, -0.7), (2.0, 1.0)])
def test_a_planar_arm_has_the_computed_pose(shoulder: float, elbow: float) -> None:
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


def test_joints_can_mimic_indirectly() -> None:
    model = parse_urdf(GRIPPER)
    assert with_mimics(model, {"left": 1.0}) == {"left": 1.0, "right": -1.25, "tip": -2.5}
    assert with_mimics(model, {"right": 2.0})["tip"] == 4.0
    assert with_mimics(model, {}) == {}


def test_a_cycle_of_mimics_is_refused() -> None:
    model = parse_urdf(
        robot(
            "x",
            "a b c",
            joint("j", "continuous", "a", "b", '<mimic joint="k"/>')
            + joint("k", "continuous", "b", "c", '<mimic joint="j"/>'),
        )
    )
    with pytest.raises(RobotModelError, match="cycle: j, k, j"):
        with_mimics(model, {})
