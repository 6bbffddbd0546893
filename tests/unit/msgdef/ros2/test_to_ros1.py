"""Converting ROS 2 types to ROS 1."""

from __future__ import annotations

from rostether.msgdef.definition_files import Kind
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.ros2 import parse
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.ros2.to_ros1 import as_ros1_specs, ros1_name

DEFINITIONS = Ros2Definitions()


def test_keeps_the_fields_of_ros2() -> None:
    header, time = as_ros1_specs(DEFINITIONS.message("std_msgs/msg/Header"), DEFINITIONS)
    assert header.full_name == "std_msgs/Header"
    assert header.text == "builtin_interfaces/Time stamp\nstring frame_id\n"
    assert time.text == "int32 sec\nuint32 nanosec\n"


def test_converts_bytes_bounds_and_constants_to_ros1() -> None:
    message = parse.parse_message(
        "byte B=255\nbool T=true\nfloat32 F=1e-3\nstring S=' x '\n"
        "byte b 7\nchar[3] c\nstring<=4[<=2] names\nint8[] many\n",
        package="x",
        name="Foo",
    )
    (spec,) = as_ros1_specs(message, DEFINITIONS)
    assert spec.text == (
        "uint8 B=255\nbool T=1\nfloat32 F=0.001\nstring S=x\n"
        "uint8 b\nuint8[3] c\nstring[] names\nint8[] many\n"
    )


def test_ros1_reads_the_text_of_every_bundled_type() -> None:
    names = [name for name in DEFINITIONS.names(Kind.MESSAGE) if "WString" not in name]
    halves = [
        f"{name}_{half}" for name in DEFINITIONS.names(Kind.SERVICE) for half in ("Request", "Response")
    ]
    for name in names + halves:
        for spec in as_ros1_specs(DEFINITIONS.message(name), DEFINITIONS):
            assert parse_message(spec.text, package=spec.package, name=spec.name) == spec


def test_names_halves_of_services_as_ros1_does() -> None:
    assert ros1_name("std_srvs/srv/SetBool_Request") == "std_srvs/SetBoolRequest"
    assert ros1_name("std_msgs/msg/String") == "std_msgs/String"


def test_wide_strings_are_strings() -> None:
    message = parse.parse_message("wstring<=3 text\nwstring[] more\n", package="x", name="Foo")
    assert as_ros1_specs(message, DEFINITIONS)[0].text == "string text\nstring[] more\n"
