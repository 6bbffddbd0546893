from __future__ import annotations

import re
from pathlib import Path

import pytest

from rostether.msgdef.registry import Registry
from rostether.serde.field_units import UNITS, unit_of
from rostether.serde.store import TypeStore

REPOSITORY = Path(__file__).parents[3]


@pytest.mark.parametrize(
    ("type_name", "path", "unit"),
    [
        ("sensor_msgs/Range", "range", "m"),
        ("sensor_msgs/Imu", "angular_velocity/x", "rad/s"),
        ("nav_msgs/Odometry", "twist/twist/linear/x", "m/s"),
        ("nav_msgs/Odometry", "pose/pose/orientation/x", ""),
        ("sensor_msgs/JointState", "position[0]", "rad"),
        ("geometry_msgs/PoseArray", "poses[1]/position/z", "m"),
        ("std_msgs/Float32", "data", ""),
        ("std_msgs/Float32", "nothing/there", ""),
        ("my_arm/Motor", "current", "mA"),
        ("my_arm/Motor", "speed", "rad/s²"),
        ("my_arm/Motor", "count", ""),
    ],
)
def test_units_of_types_and_of_comments(type_name: str, path: str, unit: str) -> None:
    registry = Registry()
    text = "float32 current  # drawn [mA]\nfloat32 speed # (in rad/s^2)\nint32 count # of [things]\n"
    registry.add_full_text("my_arm/Motor", text)
    assert unit_of(registry, TypeStore(registry).codec(type_name).tree, path) == unit


def test_a_type_whose_definition_is_not_known_has_no_units_of_comments() -> None:
    registry = Registry()
    registry.add_full_text("my_arm/Motor", "float32 current  # drawn [mA]\n")
    tree = TypeStore(registry).codec("my_arm/Motor").tree
    assert unit_of(Registry(), tree, "current") == ""


def test_the_page_has_the_same_table() -> None:
    text = (REPOSITORY / "web/src/plot/units.ts").read_text(encoding="utf-8")
    assert dict(re.findall(r'^  "(\S+ \S+)": "(\S+)",$', text, re.MULTILINE)) == UNITS
