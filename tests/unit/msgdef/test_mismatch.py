from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import UnknownTypeError
from rostether.msgdef.md5sum import message_md5sum
from rostether.msgdef.mismatch import (
    declarations,
    difference,
    explain_mismatch,
    guess_definition,
    name_of_md5sum,
)
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec

RANGE = """uint8 ULTRASOUND=0
uint8 INFRARED=1
Header header
uint8 radiation_type
float32 field_of_view
float32 min_range
float32 max_range
float32 range
"""
UNKNOWN_MD5SUM = "0123456789abcdef0123456789abcdef"


OURS = "Header header\nfloat32 range\nfloat32 max\nuint8 A=1\n"


def md5sum(text: str, registry: Registry) -> str:
    return message_md5sum(parse_message(text, package="sensor_msgs", name="Range"), registry.message)


@pytest.mark.parametrize(
    ("old", "new", "reported"),
    [
        ("float32 max_range\n", "", "lacks 'float32 max_range'"),
        ("Header header\n", "", "lacks 'std_msgs/Header header'"),
        (
            "float32 min_range\nfloat32 max_range\n",
            "",
            "lacks 'float32 min_range', lacks 'float32 max_range'",
        ),
        ("float32 range", "float64 range", "has 'float64 range' instead of 'float32 range'"),
        (
            "uint8 radiation_type",
            "int8 radiation_type",
            "has 'int8 radiation_type' instead of 'uint8 radiation_type'",
        ),
        ("uint8 INFRARED=1\n", "", "lacks the constant 'uint8 INFRARED=1'"),
        ("float32 range\n", "float32[] range\n", "has 'float32[] range' instead of 'float32 range'"),
        (
            "float32 min_range\nfloat32 max_range",
            "float32 max_range\nfloat32 min_range",
            "declares the fields in another order",
        ),
        ("uint8 radiation_type\n", "", "lacks 'uint8 radiation_type'"),
    ],
)
def test_a_small_change_is_found_and_reported_in_one_line(old: str, new: str, reported: str) -> None:
    registry = Registry()
    theirs = md5sum(RANGE.replace(old, new), registry)
    line = explain_mismatch(registry, "sensor_msgs/Range", theirs)
    assert line.startswith(f"sensor_msgs/Range: the device's md5sum {theirs} is not the known one (c005c34")
    assert f"its definition {reported}" in line
    assert "--msg-path" in line
    assert "\n" not in line


def test_two_fields_in_different_places_are_found() -> None:
    # sensor_msgs/BatteryState before the field `temperature` was added.
    line = explain_mismatch(Registry(), "sensor_msgs/BatteryState", "476f837fa6771f6e16e3bf4ef96f8770")
    assert "lacks 'float32 temperature', lacks 'float32[] cell_temperature'" in line


def test_an_older_marker_is_recognized() -> None:
    line = explain_mismatch(Registry(), "visualization_msgs/Marker", "18326976df9d29249efc939e00342cde")
    assert "lacks the constant 'uint8 DELETEALL=3'" in line


def test_the_md5sum_of_another_type_is_recognized() -> None:
    line = explain_mismatch(Registry(), "std_msgs/Int8", "8524586e34fbd7cb1c08c5f5f1ca0e57")
    assert "it belongs to std_msgs/Int16" in line


def test_a_bundled_earlier_version_is_recognized() -> None:
    line = explain_mismatch(Registry(), "turtlebot3_msgs/SensorState", "d537ed7b8d95065b6c83830430b93911")
    assert "it belongs to turtlebot3_msgs 0.1.4, which has 'uint8 cliff' instead of 'float32 cliff'" in line


def test_a_change_in_a_nested_message_is_found(tmp_path: Path) -> None:
    users = tmp_path / "my_msgs"
    users.mkdir()
    (users / "Inner.msg").write_text("int32 a\n")
    (users / "Middle.msg").write_text("Inner[] inner\nHeader header\n")
    (users / "Outer.msg").write_text("Middle middle\n")
    theirs = Registry([tmp_path]).message_type("my_msgs/Outer").md5sum
    (users / "Inner.msg").write_text("int32 a\nint32 b\n")
    line = explain_mismatch(Registry([tmp_path]), "my_msgs/Outer", theirs)
    assert "its my_msgs/Inner lacks 'int32 b'" in line


def test_an_unknown_type_shows_our_definition() -> None:
    registry = Registry()
    line = explain_mismatch(registry, "sensor_msgs/Range", UNKNOWN_MD5SUM)
    assert "of any known definition; the known one is 'std_msgs/Header header, uint8 radiation_type" in line
    assert guess_definition(registry, "sensor_msgs/Range", UNKNOWN_MD5SUM) is None
    assert name_of_md5sum(registry, UNKNOWN_MD5SUM) is None


def test_other_broken_definitions_are_ignored(tmp_path: Path) -> None:
    (tmp_path / "a_msgs").mkdir()
    (tmp_path / "a_msgs" / "Broken.msg").write_text("oops")
    registry = Registry([tmp_path])
    assert name_of_md5sum(registry, registry.message_type("std_msgs/UInt8").md5sum) == "std_msgs/UInt8"


def test_an_unknown_type_is_an_error() -> None:
    with pytest.raises(UnknownTypeError):
        explain_mismatch(Registry(), "my_arm/ServoAngles", UNKNOWN_MD5SUM)


def test_service_halves_can_be_explained() -> None:
    registry = Registry()
    half = registry.message_type("std_srvs/TriggerResponse").md5sum
    line = explain_mismatch(registry, "std_srvs/SetBoolRequest", half)
    assert line.startswith("std_srvs/SetBoolRequest: the device's md5sum")


def spec(text: str) -> MessageSpec:
    return parse_message(text, package="p", name="N")


@pytest.mark.parametrize(
    ("theirs", "reported"),
    [
        (OURS + "# prose", ""),
        (OURS.replace("float32 max\n", ""), "lacks 'float32 max'"),
        (OURS.replace("float32 range", "float64 range"), "has 'float64 range' instead of 'float32 range'"),
        (
            OURS.replace("float32 range", "float32[] range"),
            "has 'float32[] range' instead of 'float32 range'",
        ),
        (OURS + "int8 more", "also has 'int8 more'"),
        (OURS.replace("uint8 A=1", ""), "lacks the constant 'uint8 A=1'"),
        (OURS.replace("A=1", "A=2"), "has 'uint8 A=2' instead of 'uint8 A=1'"),
        (OURS + "uint8 B=2", "also has the constant 'uint8 B=2'"),
        (OURS.replace("Header header\n", ""), "lacks 'std_msgs/Header header'"),
        (
            "Header header\nfloat32 max\nfloat32 range\nuint8 A=1",
            "declares the fields in another order: std_msgs/Header header, float32 max, float32 range",
        ),
    ],
)
def test_what_differs_is_reported(theirs: str, reported: str) -> None:
    assert difference(spec(OURS), spec(theirs)) == reported


def test_the_order_of_constants_counts() -> None:
    assert "constants in another order" in difference(spec("int8 A=1\nint8 B=2"), spec("int8 B=2\nint8 A=1"))


def test_the_written_length_counts() -> None:
    assert difference(spec("int8[5] a"), spec("int8[05] a")) == "has 'int8[05] a' instead of 'int8[5] a'"


def test_many_differences_are_counted() -> None:
    other = "\n".join(f"int8 x{n}" for n in range(20))
    reported = difference(spec(OURS), spec(other))
    assert reported.endswith("and 18 more differences")
    assert len(reported) < 300


def test_declarations_are_one_line() -> None:
    assert declarations(spec(OURS)) == "std_msgs/Header header, float32 range, float32 max"
    assert declarations(spec("")) == "no fields"
    assert declarations(spec("\n".join(f"int8 x{n}" for n in range(9)))).endswith(
        "int8 x5, and 3 more fields"
    )
