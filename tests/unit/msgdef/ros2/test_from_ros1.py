"""Converting ROS 1 types to ROS 2."""

from __future__ import annotations

import pytest

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.from_ros1 import derive, ros2_field_name
from rostether.msgdef.ros2.parse import parse_message as parse_ros2
from rostether.msgdef.ros2.spec import Ros2Constant, Ros2Message

REGISTRY = Registry()
# Types whose fields or defaults differ in ROS 2.
CHANGED = {
    "geometry_msgs/Quaternion",
    "sensor_msgs/NavSatStatus",
    "sensor_msgs/Range",
    "shape_msgs/SolidPrimitive",
    "std_msgs/Header",
    "visualization_msgs/Marker",
}


def derived(text: str) -> Ros2Message:
    return derive(parse_message(text, package="my_msgs", name="Foo"), REGISTRY)


def test_converts_like_a_manual_port() -> None:
    message = derived(
        "Header header\ntime stamp\nduration[2] frameId\nstd_msgs/Time T\nfloat64[] K\nbyte b\nchar c\n"
        "geometry_msgs/Pose[3] poses\ntf/tfMessage tf\nint8 A=1\nstring some_text=it's # text\nbyte LOW=-1\n"
    )
    ported = parse_ros2(
        "std_msgs/Header header\nbuiltin_interfaces/Time stamp\nbuiltin_interfaces/Duration[2] frame_id\n"
        "builtin_interfaces/Time t\nfloat64[] k\nbyte b\nchar c\ngeometry_msgs/Pose[3] poses\n"
        "tf2_msgs/TFMessage tf\n",
        package="my_msgs",
        name="Foo",
    )
    assert message.full_name == "my_msgs/msg/Foo"
    assert message.fields == ported.fields
    assert message.constants == (
        Ros2Constant("int8", "A", 1),
        Ros2Constant("string", "SOME_TEXT", "it's # text"),
        Ros2Constant("int8", "LOW", -1),
    )


@pytest.mark.parametrize(
    ("ros1", "ros2"),
    [("D", "d"), ("frameId", "frame_id"), ("x", "x"), ("a__b_", "a_b"), ("seq2D", "seq2_d"), ("URL", "url")],
)
def test_spells_fields(ros1: str, ros2: str) -> None:
    assert ros2_field_name(ros1) == ros2


def test_most_common_types_have_the_same_fields_in_ros2() -> None:
    definitions = Ros2Definitions()
    changed = set()
    for name in REGISTRY.messages():
        spec = REGISTRY.message(name)
        ros2_name = f"{spec.package}/msg/{spec.name}"
        message = derive(spec, REGISTRY)
        assert message.full_name == ros2_name
        if definitions.has(ros2_name) and definitions.message(ros2_name).fields != message.fields:
            changed.add(name)
    assert changed == CHANGED


def test_refuses_values_that_ros2_does_not_support() -> None:
    with pytest.raises(DefinitionError, match="'d' and 'D' would both be 'd' in ROS 2"):
        derived("int8 d\nint8 D\n")
    with pytest.raises(DefinitionError, match="no arrays of length 0, such as the field 'a'"):
        derived("int8[0] a\n")
    with pytest.raises(UnknownTypeError, match="my_msgs/Foo, field 'a'"):
        derived("nobody_msgs/Bar a\n")
