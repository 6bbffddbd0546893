from __future__ import annotations

import pytest

from rostether.errors import RobotModelError
from rostether.robot.robot_model import JointType
from rostether.robot.urdf import parse_urdf
from unit.robot.robots import ARM, GRIPPER, ROVER, joint, robot

TWO = '<link name="a"/><link name="b"/>'
ENDS = '<parent link="a"/><child link="b"/>'


def with_joint(attributes: str, inside: str = ENDS) -> str:
    return f'<robot name="x">\n{TWO}\n<joint {attributes}>{inside}</joint></robot>'


def test_an_arm_is_read() -> None:
    model = parse_urdf(ARM)
    assert (model.name, model.root) == ("arm", "base")
    assert model.links == ("base", "turret", "upper", "fore", "hand")
    assert [each.type for each in model.joints.values()] == [JointType.REVOLUTE] * 3 + [JointType.FIXED]
    assert model.joints["j2"].axis == (1.0, 2.0, 3.0)
    assert model.joints["j0"].limits is not None
    assert model.joints["j0"].limits.upper == 2.5
    assert model.problems == ()


def test_mimics_and_soft_limits_are_read() -> None:
    joints = parse_urdf(GRIPPER).joints
    mimic = joints["right"].mimic
    assert mimic is not None
    assert (mimic.joint, mimic.multiplier, mimic.offset) == ("left", -1.5, 0.25)
    limits = joints["lift"].limits
    assert limits is not None
    assert (limits.soft_lower, limits.soft_upper) == (0.05, 0.15)


def test_joints_below_a_link_are_sorted_by_name() -> None:
    names = [each.name for each in parse_urdf(ROVER).joints_below("body")]
    assert names == ["drone", "mast", "sled", "wheel_left", "wheel_right"]
    assert parse_urdf(ROVER).joints_below("drone") == []


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("<robot", "not XML"),
        ('<!DOCTYPE robot [<!ENTITY a "b">]><robot name="x"/>', "DTD"),
        ("<launch/>", "not <robot>"),
        ("<COLLADA/>", "convert it to URDF"),
        (f"<robot>{TWO}</robot>", "the robot has no name"),
        (f'<robot name="x" version="2.0">{TWO}</robot>', "version 2.0"),
        ('<robot name="x"/>', "no <link>"),
        (f'<robot name="x">{TWO}</robot>', "two root links, 'a' and 'b'"),
        (f'<robot name="x">{TWO}{TWO}</robot>', "link 'a' is not unique"),
        (with_joint('type="fixed"'), "a joint has no name"),
        (with_joint('name="j"'), "joint 'j' has no type"),
        (with_joint('name="j" type="bar"'), "has the unknown type 'bar'; known: revolute"),
        (with_joint('name="j" type="fixed"', '<parent link="a"/>'), "no child link"),
        (
            with_joint('name="j" type="fixed"', '<parent link="q"/><child link="b"/>'),
            "parent link 'q' of joint 'j' does not exist",
        ),
        (with_joint('name="j" type="revolute"'), "has no limits"),
        (with_joint('name="j" type="revolute"', ENDS + '<limit effort="1"/>'), "has no velocity"),
        (with_joint('name="j" type="continuous"', ENDS + '<axis xyz="0 0 0"/>'), "zero; set a direction"),
        (with_joint('name="j" type="continuous"', ENDS + '<axis xyz="0 0"/>'), "2 numbers"),
        (with_joint('name="j" type="continuous"', ENDS + "<mimic/>"), "mimics no joint"),
        (with_joint('name="j" type="fixed"', ENDS + '<origin xyz="a 0 0"/>'), "'a', not a number"),
        (with_joint('name="j" type="fixed"', ENDS + '<origin xyz="nan 0 0"/>'), "not a number"),
        (with_joint('name="j" type="fixed"', ENDS + '<origin xyz="${x} 0 0"/>'), "expand this xacro first"),
        (
            robot("x", "a b", joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "a")),
            "no root link",
        ),
        (
            robot("x", "a b c", joint("j", "fixed", "a", "c") + joint("k", "fixed", "b", "c")),
            "child of two joints, 'j' and 'k'",
        ),
        (
            robot("x", "a b c", joint("j", "fixed", "a", "b") + joint("j", "fixed", "b", "c")),
            "joint 'j' is not unique",
        ),
    ],
)
def test_errors_name_their_line(text: str, reported: str) -> None:
    with pytest.raises(RobotModelError) as refusal:
        parse_urdf(text, file="robot.urdf")
    assert reported in str(refusal.value)
    assert str(refusal.value).startswith("robot.urdf:")
    assert "\n" not in str(refusal.value)


def test_an_error_of_a_joint_names_its_line() -> None:
    with pytest.raises(RobotModelError, match=r"^r:3: "):
        parse_urdf(with_joint('name="j" type="bar"'), file="r")


def test_deep_nesting_is_refused() -> None:
    with pytest.raises(RobotModelError, match="are nested deeper"):
        parse_urdf("<robot>" * 1000)


def test_a_raw_xacro_loads_without_its_macros() -> None:
    model = parse_urdf(
        '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="r" value="1"/>'
        '<xacro:macro name="m"><link name="${n}"/></xacro:macro><link name="a"/>'
        '<xacro:m n="q"/><gazebo reference="a"/></robot>'
    )
    assert model.links == ("a",)


def test_a_raw_xacro_that_needs_its_macros_is_reported() -> None:
    with pytest.raises(RobotModelError, match="this is xacro; expand it first"):
        parse_urdf('<robot name="x" xmlns:xacro="u"><xacro:m/></robot>')


def test_valid_shapes_and_masses_are_accepted() -> None:
    model = parse_urdf(
        '<robot name="x"><material name="red"><color rgba="1 0 0 1"/></material><link name="a">'
        '<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
        '<visual><origin xyz="0 0 1"/><geometry><box size="1 2 3"/></geometry><material name="red"/></visual>'
        '<visual><geometry><mesh filename="package://x/m.stl"/></geometry></visual>'
        '<collision><geometry><cylinder radius="1" length="2"/></geometry></collision>'
        '<collision><geometry><sphere radius="3"/></geometry></collision></link></robot>'
    )
    assert model.problems == ()


@pytest.mark.parametrize(
    ("inside", "reported"),
    [
        ("<visual/>", "no geometry"),
        ("<visual><geometry><cone/></geometry></visual>", "known: box"),
        ('<visual><geometry><box size="1 1"/></geometry></visual>', "2 numbers"),
        ("<visual><geometry><mesh/></geometry></visual>", "no filename"),
        (
            '<visual><geometry><sphere radius="1"/></geometry>'
            '<material name="m"><color rgba="255 0 0 1"/></material></visual>',
            "the rgba of material 'm' is not from 0 to 1",
        ),
        ('<collision><geometry><sphere radius="${r}"/></geometry></collision>', "not a number"),
        ('<inertial><mass value="1"/></inertial>', "needs <mass> and <inertia>"),
    ],
)
def test_a_wrong_shape_or_mass_is_reported(inside: str, reported: str) -> None:
    model = parse_urdf(f'<robot name="x"><link name="a">{inside}</link></robot>')
    assert len(model.problems) == 1
    assert reported in model.problems[0]
