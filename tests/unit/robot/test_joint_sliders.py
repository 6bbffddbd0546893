from __future__ import annotations

import pytest

from rostether.robot.joint_sliders import JointSliders, SliderKey
from rostether.robot.joint_states import JointStates
from rostether.robot.urdf import parse_urdf
from unit.robot.robots import ARM


@pytest.fixture
def states() -> JointStates:
    return JointStates(parse_urdf(ARM))


@pytest.fixture
def sliders(states: JointStates) -> JointSliders:
    return JointSliders(states, choose=lambda lower, upper: upper)


def test_keys_move_the_selected_joint(states: JointStates, sliders: JointSliders) -> None:
    sliders.press(SliderKey.DOWN)
    sliders.press(SliderKey.MORE)
    assert states.free["j1"].position == pytest.approx(4.0 / 200)
    sliders.press(SliderKey.MUCH_LESS)
    assert states.free["j1"].position == pytest.approx(4.0 / 200 - 0.4)
    assert states.free["j0"].position == 0.0
    sliders.press(SliderKey.CENTER_ONE)
    assert states.free["j1"].position == 0.0


def test_selection_wraps_around(states: JointStates, sliders: JointSliders) -> None:
    sliders.press(SliderKey.UP)
    sliders.press(SliderKey.LESS)
    assert states.free["j2"].position == pytest.approx(-0.02)


def test_keys_that_move_all_joints(states: JointStates, sliders: JointSliders) -> None:
    sliders.press(SliderKey.RANDOMIZE)
    assert [each.position for each in states.free.values()] == [2.5, 2.5, 2.5]
    sliders.press(SliderKey.CENTER)
    assert [each.position for each in states.free.values()] == [0.0, 0.0, 0.0]


def test_a_slider_stops_at_its_end(states: JointStates, sliders: JointSliders) -> None:
    for _ in range(30):
        sliders.press(SliderKey.MUCH_MORE)
    assert states.free["j0"].position == 2.5


def test_lines_show_names_values_and_knobs(sliders: JointSliders) -> None:
    lines = sliders.lines(60, 20)
    assert lines[0].startswith("> j0    0.0000".replace("    ", " " * 4))
    assert lines[1].startswith("  j1")
    assert all("●" in line for line in lines[:3])
    assert all(len(line) <= 60 for line in lines)


def test_a_small_screen_shows_the_selected_joint(sliders: JointSliders) -> None:
    sliders.press(SliderKey.UP)
    lines = sliders.lines(60, 3)
    assert lines[0].startswith("> j2")
    assert len(lines) == 3


def test_a_robot_without_joints_is_reported() -> None:
    states = JointStates(parse_urdf('<robot name="x"><link name="a"/></robot>'))
    sliders = JointSliders(states)
    sliders.press(SliderKey.MORE)
    assert sliders.lines(80, 24) == ["The robot has no joint that can be set."]
