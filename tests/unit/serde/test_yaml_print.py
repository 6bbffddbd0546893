"""Messages as `rostopic echo` prints them; test_yaml_against_rostopic compares with the real one."""

from __future__ import annotations

from typing import Any

import pytest

from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import FieldType
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.yaml_print import EchoStyle, format_message, format_value
from unit.serde.definitions import store_of

STORE = TypeStore(Registry())


def text_of(type_name: str, style: EchoStyle | None = None, /, **fields: Any) -> str:
    return format_message(STORE.codec(type_name).conform(fields), style)


def test_nested_messages_are_indented() -> None:
    assert text_of("geometry_msgs/Twist", linear={"x": 0.2}) == (
        "linear: \n  x: 0.2\n  y: 0.0\n  z: 0.0\nangular: \n  x: 0.0\n  y: 0.0\n  z: 0.0"
    )


def test_stamps() -> None:
    header: dict[str, Any] = {"seq": 1, "stamp": Time(12, 34), "frame_id": "map"}
    printed = text_of("std_msgs/Header", **header)
    assert printed == 'seq: 1\nstamp: \n  secs: 12\n  nsecs:        34\nframe_id: "map"'
    offset = text_of("std_msgs/Header", EchoStyle(time_offset=Time(13, 0)), **header)
    assert "  secs: -1\n  nsecs:        34" in offset


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("", "data: ''"),
        ("plain text", 'data: "plain text"'),
        ('say "hi"', r'data: "say \"hi\""'),
        ("back\\slash", r'data: "back\\slash"'),
        ("two\nlines", r'data: "two\nlines"'),
        ("é", r'data: "\xE9"'),
        ("\udcff", r'data: "\uFFFD"'),
    ],
)
def test_strings_are_quoted(text: str, printed: str) -> None:
    assert text_of("std_msgs/String", data=text) == printed


def test_arrays() -> None:
    assert text_of("std_msgs/UInt8MultiArray", data=b"\1\2").endswith("\ndata: [1, 2]")
    assert text_of("std_msgs/Float32MultiArray").endswith("\ndata: []")
    assert "name: \n  - a\n  - '1'\n" in text_of("sensor_msgs/JointState", name=["a", "1"])
    polygon = text_of("geometry_msgs/Polygon", points=[{"x": 1.0}, {}])
    assert polygon == (
        "points: \n  - \n    x: 1.0\n    y: 0.0\n    z: 0.0\n  - \n    x: 0.0\n    y: 0.0\n    z: 0.0"
    )


def test_char_array_is_a_list_of_numbers() -> None:
    codec = store_of(Chars="char[] data").codec("test/Chars")
    assert format_message(codec.conform({"data": b"ab"})) == "data: [97, 98]"


def test_leaving_out_arrays_and_strings() -> None:
    image = text_of("sensor_msgs/Image", EchoStyle(no_arrays=True, no_strings=True), data=b"1234")
    assert image.endswith('data: "<array type: uint8, length: 4>"')
    assert 'frame_id: "<string length: 0>"' in image
    joints = text_of("sensor_msgs/JointState", EchoStyle(no_strings=True), name=["a"], position=[1.0])
    assert 'name: "<array type: string, length: 1>"\nposition: [1.0]' in joints


def test_number_width() -> None:
    style = EchoStyle(number_width=6)
    assert text_of("std_msgs/Int32", style, data=42) == "data:     42"
    assert text_of("std_msgs/Float64", style, data=1.23456789) == "data: 1.2345"
    assert text_of("std_msgs/Bool", style, data=True) == "data: True"


def test_message_without_fields() -> None:
    assert text_of("std_msgs/Empty") == ""


@pytest.mark.parametrize(
    ("value", "field_type", "printed"),
    [
        (0.5, FieldType("float64"), "0.5"),
        ("map", FieldType("string"), '"map"'),
        (Time(1, 2), FieldType("time"), "\nsecs: 1\nnsecs:         2"),
        ([1, 2], FieldType("uint8", is_array=True), "[1, 2]"),
        (["a"], FieldType("string", is_array=True), "\n- a"),
    ],
)
def test_selected_values(value: Any, field_type: FieldType, printed: str) -> None:
    assert format_value(value, field_type) == printed


def test_selected_message_is_printed_like_a_whole_one() -> None:
    vector = STORE.codec("geometry_msgs/Vector3").message_class()
    assert format_value(vector, FieldType("geometry_msgs/Vector3")) == "x: 0.0\ny: 0.0\nz: 0.0"


def test_widths_of_lists_and_stamps() -> None:
    style = EchoStyle(number_width=5)
    assert format_value([1.5, 2.25], FieldType("float64", is_array=True), style) == "[1.500, 2.250]"
    assert "  secs:    12\n  nsecs:    34" in text_of("std_msgs/Header", style, stamp=Time(12, 34))


def test_strings_of_a_fixed_number_are_not_omitted() -> None:
    style = EchoStyle(no_strings=True)
    assert format_value(["a", "b"], FieldType("string", True, 2), style) == "\n- a\n- b"
