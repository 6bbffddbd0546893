"""Selecting fields as `rostopic echo /topic/field[0]` does, with mistakes named before the first message."""

from __future__ import annotations

from typing import Any

import pytest

from rostether.errors import ConfigError, SerializationError
from rostether.msgdef.registry import Registry
from rostether.serde.field_path import FieldPath
from rostether.serde.store import TypeStore

STORE = TypeStore(Registry())
VALUES: dict[str, dict[str, Any]] = {
    "geometry_msgs/PoseStamped": {"pose": {"position": {"x": 1.5}}},
    "sensor_msgs/LaserScan": {"ranges": [0.0, 1.0, 2.0, 3.0]},
    "sensor_msgs/Image": {"data": b"\1\2\3"},
    "tf2_msgs/TFMessage": {"transforms": [{"child_frame_id": "a"}, {"child_frame_id": "b"}]},
    "diagnostic_msgs/DiagnosticArray": {
        "status": [{"values": [{"key": "k"}, {"key": "l"}]}, {"values": [{"key": "m"}]}]
    },
}


@pytest.mark.parametrize(
    ("name", "path", "selected"),
    [
        ("geometry_msgs/PoseStamped", "/pose/position/x", 1.5),
        ("geometry_msgs/PoseStamped", "pose//position/x/", 1.5),
        ("sensor_msgs/LaserScan", "ranges[3]", 3.0),
        ("sensor_msgs/LaserScan", "ranges[-1]", 3.0),
        ("sensor_msgs/LaserScan", "ranges[1:]", [1.0, 2.0, 3.0]),
        ("sensor_msgs/LaserScan", "ranges[::2]", [0.0, 2.0]),
        ("sensor_msgs/LaserScan", "ranges[9:]", []),
        ("sensor_msgs/Image", "data", [1, 2, 3]),
        ("sensor_msgs/Image", "data[1]", 2),
        ("sensor_msgs/Image", "data[:2]", [1, 2]),
        ("tf2_msgs/TFMessage", "transforms[1]/child_frame_id", "b"),
        ("tf2_msgs/TFMessage", "transforms[:]/child_frame_id", ["a", "b"]),
        ("diagnostic_msgs/DiagnosticArray", "status[:]/values[:]/key", [["k", "l"], ["m"]]),
        ("diagnostic_msgs/DiagnosticArray", "status[:]/values[0]/key", ["k", "m"]),
    ],
)
def test_selection(name: str, path: str, selected: Any) -> None:
    codec = STORE.codec(name)
    assert FieldPath(codec, path).read(codec.conform(VALUES[name])) == selected


def test_type_of_the_last_field() -> None:
    scan = STORE.codec("sensor_msgs/LaserScan")
    assert str(FieldPath(scan, "ranges[3]").type) == "float32[]"
    assert str(FieldPath(scan, "header/stamp").type) == "time"


@pytest.mark.parametrize(
    ("name", "path", "text"),
    [
        ("geometry_msgs/Twist", "linar", "geometry_msgs/Twist has no field 'linar'; it has linear, angular"),
        ("geometry_msgs/Twist", "linear/w", "geometry_msgs/Vector3 has no field 'w'; it has x, y, z"),
        (
            "geometry_msgs/Twist",
            "linear/x/y",
            "field 'x' has no fields, so 'linear/x/y' cannot continue with 'y'",
        ),
        ("geometry_msgs/Twist", "linear[0]", "field 'linear' is a geometry_msgs/Vector3, not an array"),
        ("std_msgs/String", "data[0]", "field 'data' is a string, not an array; omit the [ ]"),
        ("tf2_msgs/TFMessage", "transforms/header", "is an array; select elements, e.g. transforms[0]"),
        ("std_msgs/Empty", "x", "std_msgs/Empty has no field 'x'; it has no fields"),
        ("std_msgs/String", "", "std_msgs/String has no field ''; it has data"),
        *[
            (
                "sensor_msgs/LaserScan",
                f"ranges{index}",
                f"'ranges{index}' selects no elements; write ranges[3] or",
            )
            for index in ("[", "[]", "[x]", "[1", "[1:2:3:4]", "[::0]", "[1]x")
        ],
    ],
)
def test_mistakes_in_a_path(name: str, path: str, text: str) -> None:
    with pytest.raises(ConfigError) as error:
        FieldPath(STORE.codec(name), path)
    assert text in str(error.value)


def test_missing_element() -> None:
    codec = STORE.codec("sensor_msgs/LaserScan")
    with pytest.raises(SerializationError, match=r"'ranges\[7\]' selects element 7 of 'ranges', which has 0"):
        FieldPath(codec, "ranges[7]").read(codec.message_class())
