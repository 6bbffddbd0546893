"""The package examples/mearm can be found, described and loaded without a build."""

from __future__ import annotations

import os

import pytest

from interop.mearm_workspace import EXAMPLE, PACKAGE
from rostether.launch.loading import load_launch
from rostether.launch.plan import LaunchPlan
from rostether.launch.substitution import LaunchContext
from rostether.msgdef.registry import Registry
from rostether.packages.package_xml import parse_package_xml
from rostether.packages.search_path import find_packages
from rostether.robot.robot_model import JointType
from rostether.robot.urdf import parse_urdf
from rostether.robot.xacro import expand_xacro

MODEL = PACKAGE / "urdf" / "robot.urdf.xacro"
JOINTS = ["joint_0", "joint_1", "joint_2", "joint_3"]


def planned(package: str, file: str, **arguments: str) -> LaunchPlan:
    packages = find_packages([EXAMPLE])
    return load_launch([packages[package] / "launch" / file], arguments, LaunchContext({}, packages))


def nodes(plan: LaunchPlan) -> dict[str, str]:
    return {node.name: f"{node.package}/{node.type}" for node in plan.nodes}


def test_both_packages_are_found_and_described() -> None:
    packages = find_packages([EXAMPLE])
    assert sorted(packages) == ["mearm_model", "mearm_move"]
    for name, folder in packages.items():
        package = parse_package_xml((folder / "package.xml").read_bytes())
        assert (package.name, package.version) == (name, "1.0.0")
        assert package.maintainers
        assert package.licenses


def test_definitions() -> None:
    registry = Registry([EXAMPLE], bundled=False)
    assert registry.messages("mearm_model") == ["mearm_model/ServoAngles"]
    assert registry.services("mearm_model") == ["mearm_model/MoveArm", "mearm_model/MoveJoints"]


@pytest.mark.parametrize("name", ["move.py", "filter.py"])
def test_nodes_can_be_started(name: str) -> None:
    script = PACKAGE / "scripts" / name
    assert os.access(script, os.X_OK)
    assert script.read_text().startswith("#!/usr/bin/env python3\n")
    compile(script.read_text(), str(script), "exec")


@pytest.mark.parametrize("package", ["mearm_model", "mearm_move"])
def test_service_launch(package: str) -> None:
    plan = planned(package, "service.launch", port="/dev/ttyACM0")
    assert nodes(plan) == {
        "robot_state_publisher": "robot_state_publisher/robot_state_publisher",
        "rviz": "rviz/rviz",
        "mearm_controller": "mearm_model/filter.py",
        "robot_joint_mover": "mearm_model/move.py",
        "mearm": "rosserial_python/serial_node.py",
    }
    parameters = plan.parameters
    assert parameters["/mearm/port"] == "/dev/ttyACM0"
    assert parameters["/mearm/baud"] == 115200
    assert parameters["/position_sets/set3"] == [-0.25, 0.0, 0.25, 0.5]
    assert parameters["/robot_description"] == MODEL.read_text()


@pytest.mark.parametrize(
    ("use_gui", "publisher"), [("true", "joint_state_publisher_gui"), ("false", "joint_state_publisher")]
)
def test_display_launch(use_gui: str, publisher: str) -> None:
    found = nodes(planned("mearm_model", "display.launch", use_gui=use_gui, rviz="false"))
    assert sorted(found) == sorted(["mearm_controller", "robot_state_publisher", publisher])


def test_the_model_is_the_same_as_text_and_expanded() -> None:
    pytest.importorskip("xacro", reason='xacro is not installed (pip install "rostether[robot]")')
    raw = parse_urdf(MODEL.read_text())
    expanded = parse_urdf(expand_xacro(MODEL, {}, packages={}))
    revolute = [name for name, joint in raw.joints.items() if joint.type is JointType.REVOLUTE]
    assert revolute == JOINTS
    assert raw.joints == {name: expanded.joints[name] for name in raw.joints}
    assert all(
        joint.type is JointType.FIXED for name, joint in expanded.joints.items() if name not in raw.joints
    )
