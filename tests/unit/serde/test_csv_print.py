"""Messages as `rostopic echo -p` prints them; test_yaml_against_rostopic compares with the real one."""

from __future__ import annotations

from typing import Any

import pytest

from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.csv_print import csv_header, csv_row
from rostether.serde.store import TypeStore
from rostether.serde.yaml_print import EchoStyle

STORE = TypeStore(Registry())
NOW = Time(100, 7)


def lines(type_name: str, style: EchoStyle | None = None, /, **fields: Any) -> tuple[str, str]:
    message = STORE.codec(type_name).conform(fields)
    return csv_header(message, style), csv_row(message, NOW, style)


def test_time_is_now_without_a_header() -> None:
    assert lines("std_msgs/Bool", data=True) == ("%time,field.data", "100000000007,1")


def test_time_is_the_headers_stamp() -> None:
    header, row = lines("geometry_msgs/PointStamped", header={"stamp": Time(5, 1)}, point={"x": 0.5})
    assert header == (
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.point.x,field.point.y,field.point.z"
    )
    assert row == "5000000001,0,5000000001,,0.5,0.0,0.0"


def test_offset() -> None:
    style = EchoStyle(time_offset=Time(4, 0))
    _, row = lines("geometry_msgs/PointStamped", style, header={"stamp": Time(5, 1)})
    assert row.startswith("1000000001,0,1000000001,,")


def test_arrays_have_a_column_for_each_element() -> None:
    header, row = lines("sensor_msgs/JointState", name=["a", "b"], position=[1.0])
    assert header.endswith(",field.name0,field.name1,field.position0")
    assert row.endswith(",a,b,1.0")
    assert lines("geometry_msgs/Polygon", points=[{"x": 2.0}]) == (
        "%time,field.points0.x,field.points0.y,field.points0.z",
        "100000000007,2.0,0.0,0.0",
    )


@pytest.mark.parametrize("name", ["std_msgs/Empty", "geometry_msgs/Polygon"])
def test_nothing_to_print(name: str) -> None:
    assert lines(name) == ("%time,", "100000000007,")


def test_leaving_out_arrays_and_strings() -> None:
    header, row = lines(
        "sensor_msgs/JointState", EchoStyle(no_arrays=True, no_strings=True), position=[1.0], name=["a"]
    )
    assert (header, row) == ("%time,field.header.seq,field.header.stamp", "0,0,0")


def test_bytes_of_a_message_are_omitted_unless_selected() -> None:
    assert lines("std_msgs/ByteMultiArray", data=[1])[0].endswith("field.data0")
    assert lines("std_msgs/UInt8MultiArray", data=[1])[0] == "%time,field.layout.data_offset"
    assert (csv_header([7, 8]), csv_row([7, 8], NOW)) == ("%time,field0,field1", "100000000007,7,8")
