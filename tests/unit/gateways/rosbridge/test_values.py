from __future__ import annotations

import json
import math
import time
from typing import Any

import pytest

from rostether.errors import SerializationError
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.values import JsonForm, write_json
from rostether.msgdef.registry import Registry
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.rostime import Time
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore

NOW = Time(1_700_000_000, 5)
STORE = TypeStore(Registry())


def codec(name: str) -> Codec:
    return STORE.codec(name)


def out(name: str, value: dict[str, Any], style: Style = Style.ROS1) -> Any:
    values = JsonForm(style).to_json(codec(name), codec(name).encode(value))
    return json.loads(write_json(values))


def back(name: str, value: object) -> Any:
    return codec(name).decode(JsonForm().from_json(codec(name), value, NOW))


def learned(definition: str) -> Codec:
    registry = Registry(bundled=False)
    registry.add_full_text("test_msgs/Thing", definition)
    return TypeStore(registry).codec("test_msgs/Thing")


def test_nested_messages_become_objects() -> None:
    value = {"header": {"seq": 3, "stamp": Time(7, 8), "frame_id": "map"}, "pose": {"position": {"x": 1.5}}}
    assert out("geometry_msgs/PoseStamped", value) == {
        "header": {"seq": 3, "stamp": {"secs": 7, "nsecs": 8}, "frame_id": "map"},
        "pose": {
            "position": {"x": 1.5, "y": 0.0, "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0},
        },
    }


def test_ros2_clients_get_their_words() -> None:
    value = {"seq": 3, "stamp": Time(7, 8), "frame_id": "map"}
    assert out("std_msgs/Header", value, Style.ROS2) == {
        "stamp": {"sec": 7, "nanosec": 8},
        "frame_id": "map",
    }


def test_bytes_are_base64_both_ways() -> None:
    assert out("std_msgs/UInt8MultiArray", {"data": bytes(range(6))})["data"] == "AAECAwQF"
    assert back("std_msgs/UInt8MultiArray", {"data": "AAECAwQF"}).data == bytes(range(6))
    assert back("std_msgs/UInt8MultiArray", {"data": "AAEC\nAwQF\n"}).data == bytes(range(6))
    assert back("std_msgs/UInt8MultiArray", {"data": ""}).data == b""
    assert back("std_msgs/UInt8MultiArray", {"data": [0, 255]}).data == b"\x00\xff"


def test_other_arrays_are_lists() -> None:
    value = {"name": ["a", "ü"], "position": [1.0, 2.5]}
    assert out("sensor_msgs/JointState", value)["position"] == [1.0, 2.5]
    assert out("sensor_msgs/JointState", value)["name"] == ["a", "ü"]
    assert back("sensor_msgs/JointState", {"position": [1, 2.5, None]}).position[:2] == [1.0, 2.5]


def test_arrays_of_messages_and_times() -> None:
    thing = learned("time[] times\nduration[2] spans\nbool[] flags\nstring[] names\nint8 class\n")
    values = {"times": [Time(1, 2)], "flags": [True, False], "names": ["x"], "class": -3}
    assert JsonForm().to_json(thing, thing.encode(values)) == {
        "times": [{"secs": 1, "nsecs": 2}],
        "spans": [{"secs": 0, "nsecs": 0}] * 2,
        "flags": [True, False],
        "names": ["x"],
        "class": -3,
    }


def test_what_json_has_no_number_for_is_null() -> None:
    value = {"ranges": [1.0, math.nan, math.inf, -math.inf], "range_max": math.inf}
    found = out("sensor_msgs/LaserScan", value)
    assert found["ranges"] == [1.0, None, None, None]
    assert found["range_max"] is None


def test_null_is_nan_for_a_float_and_no_integer() -> None:
    assert math.isnan(back("std_msgs/Float32", {"data": None}).data)
    assert math.isnan(back("std_msgs/Float64MultiArray", {"data": [1, None]}).data[1])
    with pytest.raises(SerializationError, match="needs an int32 for field data, got null"):
        back("std_msgs/Int32", {"data": None})


def test_text_that_is_not_utf8_can_be_written() -> None:
    assert out("std_msgs/String", {"data": "a\udcffb"}) == {"data": "a\ufffdb"}


def test_half_a_pair_of_utf16_is_replaced() -> None:
    assert back("std_msgs/String", {"data": "a\ud83db"}).data == "a\ufffdb"
    assert back("std_msgs/String", {"data": "\ud83d\ude00"}).data == "\U0001f600"


def test_missing_fields_are_zero() -> None:
    assert back("geometry_msgs/Twist", {"linear": {"x": 2}}).linear.x == 2.0
    assert back("geometry_msgs/Twist", {}).angular.z == 0.0


@pytest.mark.parametrize("header", [{}, {"header": {}}, {"header": {"stamp": "now"}}])
def test_a_header_without_stamp_gets_the_time_now(header: dict[str, Any]) -> None:
    assert back("geometry_msgs/PoseStamped", header).header.stamp == NOW


def test_a_stamp_of_zero_stays() -> None:
    value = {"header": {"stamp": {"secs": 0, "nsecs": 0}}}
    assert back("geometry_msgs/PoseStamped", value).header.stamp == Time(0, 0)


@pytest.mark.parametrize("stamp", [{"secs": 4, "nsecs": 5}, {"sec": 4, "nanosec": 5}])
def test_times_in_either_ros_words(stamp: dict[str, int]) -> None:
    assert back("std_msgs/Time", {"data": stamp}).data == Time(4, 5)
    assert back("std_msgs/Duration", {"data": stamp}).data == (4, 5)


def test_definitions_of_ros2_itself_are_known() -> None:
    header = TypeStore(NativeRegistry.from_environment(environ={})).codec("std_msgs/Header")
    form = JsonForm(Style.ROS2)
    for value in ({}, {"stamp": "now"}, {"seq": 1, "stamp": {"secs": NOW.secs, "nsecs": NOW.nsecs}}):
        assert form.to_json(header, form.from_json(header, value, NOW)) == {
            "stamp": {"sec": NOW.secs, "nanosec": NOW.nsecs},
            "frame_id": "",
        }


def test_whole_floats_are_integers() -> None:
    assert back("std_msgs/Int32", {"data": 3.0}).data == 3


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("std_msgs/Int32", {"data": "x"}, 'std_msgs/Int32 needs an int32 for field data, got "x"'),
        ("std_msgs/Int32", {"data": 1.5}, "std_msgs/Int32 needs an int32 for field data, got 1.5"),
        ("std_msgs/Int32", {"data": True}, "std_msgs/Int32 needs an int32 for field data, got true"),
        ("std_msgs/UInt8", {"data": 300}, "field 'data' of std_msgs/UInt8 needs a uint8"),
        ("std_msgs/Bool", {"data": 1}, "std_msgs/Bool needs a bool for field data, got 1"),
        ("std_msgs/String", {"data": 1}, "std_msgs/String needs a string for field data, got 1"),
        ("std_msgs/String", {"date": ""}, "std_msgs/String has no field date; it has data"),
        ("std_msgs/String", [], r"std_msgs/String needs an object \(std_msgs/String\), got \[\]"),
        ("std_msgs/Empty", {"x": 1}, "std_msgs/Empty has no field x; it has no fields"),
        ("geometry_msgs/Twist", {"linear": {"q": 1}}, "geometry_msgs/Twist has no field linear.q; it has x"),
        ("geometry_msgs/Twist", {"linear": {"x": ""}}, 'needs a float64 for field linear.x, got ""'),
        (
            "geometry_msgs/Polygon",
            {"points": [{}, {"x": "a"}]},
            'a float32 for field points\\[1\\].x, got "a"',
        ),
        ("std_msgs/Time", {"data": {"secs": "a"}}, 'an integer for field data.secs, got "a"'),
        ("std_msgs/Time", {"data": {"minutes": 1}}, "has no field data.minutes"),
        ("std_msgs/Time", {"data": 5}, "needs a time, an object of secs and nsecs for field data, got 5"),
        ("std_msgs/Time", {"data": {"secs": -1}}, "field 'data' of std_msgs/Time needs a time"),
        ("std_msgs/UInt8MultiArray", {"data": "A"}, 'for field data, got "A"'),
        ("std_msgs/UInt8MultiArray", {"data": "data:image/png;base64,AQID"}, "needs base64 or a list"),
        ("std_msgs/UInt8MultiArray", {"data": "ü"}, "needs base64 or a list"),
        (
            "std_msgs/UInt8MultiArray",
            {"data": [256]},
            r"field 'data\[0\]' of std_msgs/UInt8MultiArray needs a uint8",
        ),
        ("std_msgs/Float64MultiArray", {"data": {"0": 1}}, r"a list \(float64\[\]\) for field data"),
        ("std_msgs/Float64MultiArray", {"data": [1, "b"]}, r'for field data\[1\], got "b"'),
        ("sensor_msgs/CameraInfo", {"K": [1, 2]}, "field 'K' of sensor_msgs/CameraInfo needs 9 elements"),
        ("std_msgs/Float64MultiArray", {"data": "x" * 10_000}, 'got "xxx'),
    ],
)
def test_what_does_not_fit_is_named(name: str, value: object, sentence: str) -> None:
    with pytest.raises(SerializationError, match=sentence) as error:
        back(name, value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", STORE.registry.messages("sensor_msgs") + STORE.registry.messages("nav_msgs"))
def test_every_type_comes_back_as_it_went(name: str) -> None:
    zero = codec(name).encode({})
    values = JsonForm().to_json(codec(name), zero)
    assert JsonForm().from_json(codec(name), json.loads(write_json(values)), NOW) == zero


def test_arrays_of_messages_have_a_limit() -> None:
    with pytest.raises(SerializationError, match="at most 262144 elements in total for field points"):
        back("geometry_msgs/Polygon", {"points": [{}] * 262_145})


def test_a_million_numbers_take_no_time_each() -> None:
    value = {"data": [1.5] * 1_000_000}
    began_s = time.process_time()
    assert len(back("std_msgs/Float64MultiArray", value).data) == 1_000_000
    assert time.process_time() - began_s < 5.0
