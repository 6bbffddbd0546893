"""Which fields match, which types have another name in ROS 2, and what is refused rather than guessed."""

from __future__ import annotations

import struct

import pytest

from rostether.errors import TypeMismatchError
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.rostime import Time
from rostether.serde.cdr.converter import CdrConverter, compile_message
from rostether.serde.cdr.renamed_types import (
    ros1_message_name,
    ros1_service_name,
    ros2_message_name,
    ros2_service_name,
)
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import TypeTrees
from unit.serde.cdr.pairs import Pairs, own_fields, pair

STORE = TypeStore(Registry())
REGISTRY = STORE.registry
COMMON = (
    "actionlib_msgs", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs", "sensor_msgs",
    "shape_msgs", "std_msgs", "std_srvs", "stereo_msgs", "tf", "tf2_msgs", "trajectory_msgs",
    "visualization_msgs",
)  # fmt: skip
# Fields of a type that one side lacks, and types that ROS 2 does not have at all; every other type of the
# common packages has the same fields on both sides, in all distributions.
ONLY_IN_ROS1 = {"rosgraph_msgs/Log": ("topics",), "std_msgs/Header": ("seq",)}
ONLY_IN_ROS2 = {
    "sensor_msgs/Range": ("variance",),
    "shape_msgs/SolidPrimitive": ("polygon",),
    "visualization_msgs/Marker": ("texture_resource", "texture", "uv_coordinates", "mesh_file"),
}
NOT_IN_ROS2 = {
    *(f"nav_msgs/GetMap{part}" for part in ("Action", "Goal", "Result", "Feedback")),
    *(f"nav_msgs/GetMapAction{part}" for part in ("Goal", "Result", "Feedback")),
    *(f"tf2_msgs/LookupTransform{part}" for part in ("Action", "Goal", "Result", "Feedback")),
    *(f"tf2_msgs/LookupTransformAction{part}" for part in ("Goal", "Result", "Feedback")),
    "rosgraph_msgs/TopicStatistics",
    "tf/FrameGraph",
}


def converter_of(ros1_name: str, ros2_name: str, definitions: Ros2Definitions) -> CdrConverter:
    ros2 = definitions.message(ros2_name)
    return compile_message(TypeTrees(REGISTRY).struct(ros1_name), ros2, definitions.message)


@pytest.mark.parametrize("distro", ["humble", "iron", "jazzy", "kilted", "rolling"])
def test_every_common_message(distro: str) -> None:
    definitions = Ros2Definitions(distro=distro)
    for name in (name for package in COMMON for name in REGISTRY.messages(package)):
        ros2_name = ros2_message_name(name)
        assert definitions.has(ros2_name) == (name not in NOT_IN_ROS2), name
        if name in NOT_IN_ROS2:
            continue
        converter = converter_of(name, ros2_name, definitions)
        assert own_fields(converter)[0] == ONLY_IN_ROS1.get(name, ()), name
        if not (name == "sensor_msgs/Range" and distro == "humble"):
            assert own_fields(converter)[1] == ONLY_IN_ROS2.get(name, ()), name


@pytest.mark.parametrize("distro", ["humble", "jazzy", "kilted"])
def test_every_common_service(distro: str) -> None:
    definitions = Ros2Definitions(distro=distro)
    for name in (name for package in COMMON for name in REGISTRY.services(package)):
        ros2_name = ros2_service_name(name)
        assert definitions.has(ros2_name) == (name not in NOT_IN_ROS2), name
        if name in NOT_IN_ROS2:
            continue
        for half in ("Request", "Response"):
            converter = converter_of(f"{name}{half}", f"{ros2_name}_{half}", definitions)
            assert own_fields(converter) == ((), ()), name


@pytest.mark.parametrize(
    ("ros1", "ros2"),
    [
        ("std_msgs/Time", "builtin_interfaces/msg/Time"),
        ("std_msgs/Duration", "builtin_interfaces/msg/Duration"),
        ("rosgraph_msgs/Log", "rcl_interfaces/msg/Log"),
        ("sensor_msgs/Imu", "sensor_msgs/msg/Imu"),
        ("std_srvs/SetBoolRequest", "std_srvs/srv/SetBool_Request"),
    ],
)
def test_names_of_messages(ros1: str, ros2: str) -> None:
    assert ros1_message_name(ros2) == ros1
    if "/srv/" not in ros2:
        assert ros2_message_name(ros1) == ros2


def test_names_with_one_way_back() -> None:
    assert ros2_message_name("tf/tfMessage") == "tf2_msgs/msg/TFMessage"
    assert ros1_message_name("tf2_msgs/msg/TFMessage") == "tf2_msgs/TFMessage"
    assert ros2_service_name("std_srvs/SetBool") == "std_srvs/srv/SetBool"
    assert ros2_service_name("roscpp/Empty") == "std_srvs/srv/Empty"
    assert ros1_service_name("std_srvs/srv/SetBool") == "std_srvs/SetBool"


@pytest.mark.parametrize("name", ["Time", "Duration"])
def test_stamp_as_a_message(name: str) -> None:
    converter = converter_of(f"std_msgs/{name}", f"builtin_interfaces/msg/{name}", Ros2Definitions())
    assert converter.to_cdr(b"abcdefgh") == b"\0\1\0\0abcdefgh"
    assert converter.from_cdr(b"\0\1\0\0abcdefgh") == b"abcdefgh"


def test_transforms_of_before() -> None:
    codec = STORE.codec("tf/tfMessage")
    payload = codec.encode({"transforms": [{"header": {"frame_id": "map"}, "child_frame_id": "odom"}] * 2})
    old = converter_of("tf/tfMessage", "tf2_msgs/msg/TFMessage", Ros2Definitions())
    new = converter_of("tf2_msgs/TFMessage", "tf2_msgs/msg/TFMessage", Ros2Definitions())
    assert old.to_cdr(payload) == new.to_cdr(payload)
    assert old.from_cdr(old.to_cdr(payload)) == payload


@pytest.mark.parametrize(("ros1", "ros2"), [(1, 10), (2, 20), (4, 30), (8, 40), (16, 50)])
def test_log_record(ros1: int, ros2: int) -> None:
    codec = STORE.codec("rosgraph_msgs/Log")
    converter = converter_of("rosgraph_msgs/Log", "rcl_interfaces/msg/Log", Ros2Definitions())
    record = {"header": {"stamp": Time(3, 4)}, "level": ros1, "name": "/n", "msg": "hi", "line": 7}
    payload = codec.encode(codec.conform(record))
    cdr = converter.to_cdr(payload)
    assert struct.unpack_from("<iIB", cdr, 4) == (3, 4, ros2)
    assert converter.from_cdr(cdr) == payload
    dropped = codec.conform(
        record | {"topics": ["/a"], "header": {"stamp": Time(3, 4), "seq": 9, "frame_id": "x"}}
    )
    assert converter.to_cdr(codec.encode(dropped)) == cdr


def test_log_severities_between_two() -> None:
    converter = pair("byte level", "uint8 level")
    assert converter.to_cdr(b"\2")[4:] == b"\2"
    log = converter_of("rosgraph_msgs/Log", "rcl_interfaces/msg/Log", Ros2Definitions())
    codec = STORE.codec("rosgraph_msgs/Log")
    assert codec.decode(log.from_cdr(log.to_cdr(codec.encode({"level": 3})))).level == 2


@pytest.mark.parametrize(
    ("ros1", "ros2", "reason"),
    [
        ("int32 a", "int64 a", "'a' is int32 in ROS 1 and int64 in ROS 2"),
        ("int8 a", "uint8 a", "'a' is int8 in ROS 1 and uint8 in ROS 2"),
        ("float32 a", "int32 a", "'a' is float32 in ROS 1 and int32 in ROS 2"),
        ("float64[9] a", "float64[] a", "'a' is float64[9] in ROS 1 and float64[] in ROS 2"),
        ("float64[] a", "float64 a", "'a' is float64[] in ROS 1 and float64 in ROS 2"),
        ("string a", "uint8[] a", "'a' is string in ROS 1 and uint8[] in ROS 2"),
        ("time a", "builtin_interfaces/Duration a", "'a' is time in ROS 1"),
        ("int32 a", "N a", "'a' is int32 in ROS 1"),
        ("int32 speed", "int32 velocity", "only ROS 1 has 'speed' and only ROS 2 has 'velocity'"),
    ],
)
def test_types_that_do_not_fit(ros1: str, ros2: str, reason: str) -> None:
    with pytest.raises(TypeMismatchError) as caught:
        Pairs({"M": ros1}, {"M": ros2, "N": "int32 x"}).converter()
    assert reason in str(caught.value)
    assert "--msg-path" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_value_that_does_not_fit_is_reported_with_its_path() -> None:
    pairs = Pairs({"M": "N[] parts", "N": "int32 speed"}, {"M": "N[] parts", "N": "int32 velocity"})
    with pytest.raises(TypeMismatchError, match=r"in 'parts\[\]'"):
        pairs.converter()


def test_names_of_nested_types_may_differ() -> None:
    converter = Pairs({"M": "N n", "N": "uint8 x"}, {"M": "Other n", "Other": "uint8 x"}).converter()
    assert converter.to_cdr(b"\5") == b"\0\1\0\0\5"


def test_spellings_that_two_fields_share_meet_only_by_name() -> None:
    converter = pair("uint8 a\nuint8 A", "uint8 a")
    assert own_fields(converter)[0] == ("A",)
    assert converter.to_cdr(b"\1\2") == b"\0\1\0\0\1"
