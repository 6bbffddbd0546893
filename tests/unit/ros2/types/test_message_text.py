"""Expected texts: those that rosidl_runtime_py and rclpy print for the same messages."""

from __future__ import annotations

from typing import Any

import pytest

from rostether.errors import SerializationError
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.types.message_text import MessageText, TextStyle
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeClasses
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from rostether.serde.yaml_form import fill_or_default

REGISTRY = NativeRegistry(Ros2Definitions(), Registry())
STORE = TypeStore(REGISTRY, NativeClasses(REGISTRY))
NOW = Time(12, 34)


def fill(name: str, *values: Any) -> Message:
    return fill_or_default(STORE.codec(name), list(values), now=lambda: NOW)


def text(name: str, fields: dict[str, Any], **style: Any) -> str:
    printer = MessageText(REGISTRY.ros2_message, TextStyle(**style))
    return printer.yaml(fill(name, fields), REGISTRY.ros2_message(name))


def python(name: str, fields: dict[str, Any]) -> str:
    printer = MessageText(REGISTRY.ros2_message, TextStyle())
    return printer.python(fill(name, fields), REGISTRY.ros2_message(name))


def test_yaml() -> None:
    assert text("std_msgs/Empty", {}) == "{}\n"
    assert text("std_msgs/String", {"data": "yes"}) == "data: 'yes'\n"
    assert text("std_msgs/String", {"data": "grüße\n"}) == "data: 'grüße\n\n  '\n"
    # Also characters beyond 16 bits, which libyaml escapes.
    assert text("std_msgs/String", {"data": "😀 grüße"}) == "data: 😀 grüße\n"
    assert text("std_msgs/String", {"data": "\\U0001F600"}) == "data: \\U0001F600\n"
    assert text("std_msgs/String", {"data": "a " * 100}, truncate_length=None) == f"data: '{'a ' * 100}'\n"
    # rclpy shows a byte as a text of one character.
    assert text("diagnostic_msgs/DiagnosticStatus", {"level": 2, "name": "arm"}) == (
        "level: \"\\x02\"\nname: arm\nmessage: ''\nhardware_id: ''\nvalues: []\n"
    )
    assert text("std_msgs/UInt8MultiArray", {"data": [1, 2]}).endswith("data_offset: 0\ndata:\n- 1\n- 2\n")
    assert text("builtin_interfaces/Time", {"sec": 1}, flow_style=True) == "{sec: 1, nanosec: 0}\n"


def test_yaml_without_arrays_and_with_cut_texts() -> None:
    joints = {"name": ["a", "b"], "position": [0.5, 1.5]}
    assert "name: '<sequence type: string, length: 2>'\n" in text(
        "sensor_msgs/JointState", joints, no_arrays=True
    )
    assert "position:\n- 0.5\n- '...'\n" in text("sensor_msgs/JointState", joints, truncate_length=1)


def test_csv() -> None:
    printer = MessageText(REGISTRY.ros2_message, TextStyle())
    message = fill("sensor_msgs/JointState", {"header": "auto", "name": ["a", "b"], "position": [0.5]})
    assert printer.csv(message, REGISTRY.ros2_message("sensor_msgs/JointState")) == "12,34,,a,b,0.5,,"


def test_python() -> None:
    assert python("std_msgs/String", {"data": "it's"}) == 'std_msgs.msg.String(data="it\'s")'
    assert python("diagnostic_msgs/DiagnosticStatus", {"level": 1}) == (
        "diagnostic_msgs.msg.DiagnosticStatus(level=b'\\x01', name='', message='', hardware_id='', values=[])"
    )
    assert python("std_srvs/SetBoolRequest", {"data": True}) == "std_srvs.srv.SetBool_Request(data=True)"
    assert python("sensor_msgs/CompressedImage", {"data": [97, 98], "header": {"stamp": "now"}}) == (
        "sensor_msgs.msg.CompressedImage(header=std_msgs.msg.Header(stamp=builtin_interfaces.msg.Time("
        "sec=12, nanosec=34), frame_id=''), format='', data=[97, 98])"
    )


def test_defaults() -> None:
    assert fill("geometry_msgs/Pose", {}).orientation.w == 1.0
    assert fill("geometry_msgs/Pose", {"orientation": {"x": 1}}).orientation.w == 1.0
    assert fill("geometry_msgs/PoseArray", {"poses": [{}]}).poses[0].orientation.w == 1.0
    assert fill("geometry_msgs/Quaternion", 1, 2, 3, 4).w == 4.0
    assert fill("std_msgs/Bool", True).data is True


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("geometry_msgs/Pose", [{"orientation": 5}]),
        ("geometry_msgs/PoseArray", [{"poses": 5}]),
        ("geometry_msgs/Quaternion", [1, 2]),
        ("geometry_msgs/Pose", [{"nope": 5}]),
    ],
)
def test_mistakes_are_reported(name: str, values: list[Any]) -> None:
    with pytest.raises(SerializationError):
        fill(name, *values)
