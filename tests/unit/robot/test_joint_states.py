from __future__ import annotations

import math

import pytest

from rostether.errors import RobotModelError
from rostether.robot.joint_states import JointStates, JointStateSettings
from rostether.robot.robot_model import Mimic
from rostether.robot.urdf import parse_urdf
from unit.robot.robots import ARM, GRIPPER, ROVER, joint, robot


def test_zeros_are_published_in_the_robots_order() -> None:
    values = JointStates(parse_urdf(ARM)).values()
    assert values.name == ["j0", "j1", "j2"]
    assert values.position == [0.0, 0.0, 0.0]
    assert values.velocity == values.effort == []


def test_a_range_without_zero_starts_in_its_middle() -> None:
    states = JointStates(parse_urdf(ROVER))
    assert states.free["mast"].zero == pytest.approx(-0.3)
    assert (states.free["wheel_left"].lower, states.free["wheel_left"].upper) == (-math.pi, math.pi)


@pytest.mark.parametrize(("smallest", "limits"), [(True, (0.05, 0.15)), (False, (0.02, 0.2))])
def test_soft_limits_count_by_default(smallest: bool, limits: tuple[float, float]) -> None:
    settings = JointStateSettings(use_smallest_joint_limits=smallest)
    lift = JointStates(parse_urdf(GRIPPER), settings).free["lift"]
    assert (lift.lower, lift.upper) == limits


def test_mimicking_joints_follow() -> None:
    states = JointStates(parse_urdf(GRIPPER))
    assert list(states.free) == ["lift", "left"]
    states.receive(["left", "right", "strange"], [1.0, 5.0, 5.0])
    assert states.values().position[1:] == [1.0, -1.25, -2.5]


def test_mimic_tags_may_be_ignored() -> None:
    states = JointStates(parse_urdf(GRIPPER), JointStateSettings(use_mimic_tags=False))
    assert list(states.free) == ["lift", "left", "right", "tip"]


def test_dependent_joints_may_be_set() -> None:
    settings = JointStateSettings(dependent_joints={"j1": Mimic("j0", 2.0, 0.5)})
    states = JointStates(parse_urdf(ARM), settings)
    states.receive(["j0"], [1.0], [0.25], [3.0])
    values = states.values()
    assert values.position == [1.0, 2.5, 0.0]
    assert values.velocity == [0.25, 0.5, 0.0]
    assert values.effort == [3.0, 3.0, 0.0]


def test_short_lists_leave_other_joints_unchanged() -> None:
    states = JointStates(parse_urdf(ARM))
    states.receive(["j0", "j1"], [1.0])
    assert states.values().position == [1.0, 0.0, 0.0]


def test_defaults_may_be_omitted_or_added() -> None:
    none = JointStates(parse_urdf(ARM), JointStateSettings(publish_default_positions=False))
    assert none.values().position == []
    full = JointStateSettings(publish_default_velocities=True, publish_default_efforts=True)
    values = JointStates(parse_urdf(ARM), full).values()
    assert values.velocity == values.effort == [0.0, 0.0, 0.0]


def test_steps_go_back_and_forth_between_limits() -> None:
    states = JointStates(parse_urdf(ARM), JointStateSettings(delta=1.0))
    seen = []
    for _ in range(8):
        states.step()
        seen.append(states.free["j0"].position)
    assert seen == [1.0, 2.0, 2.5, 1.5, 0.5, -0.5, -1.5, -1.5]


def test_continuous_joints_rotate() -> None:
    states = JointStates(parse_urdf(ROVER), JointStateSettings(delta=3.0))
    states.step()
    states.step()
    assert states.free["wheel_left"].position == -math.pi


def test_positions_stay_within_limits() -> None:
    states = JointStates(parse_urdf(ARM))
    states.set_position("j0", 9.0)
    assert states.free["j0"].position == 2.5
    states.center()
    assert states.free["j0"].position == 0.0


@pytest.mark.parametrize(
    ("leader", "reported"), [("k", "cycle: j, k, j"), ("nowhere", "not a movable joint of the robot")]
)
def test_mimicking_an_unknown_joint_is_refused(leader: str, reported: str) -> None:
    text = robot(
        "x",
        "a b c",
        joint("j", "continuous", "a", "b", f'<mimic joint="{leader}"/>')
        + joint("k", "continuous", "b", "c", '<mimic joint="j"/>'),
    )
    with pytest.raises(RobotModelError, match=reported):
        JointStates(parse_urdf(text))
