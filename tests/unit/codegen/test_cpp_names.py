from __future__ import annotations

import itertools

import pytest

from rostether.codegen.cpp_names import (
    class_name,
    include_guard,
    name_members,
    namespace_name,
    qualified_class,
)
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.registry import Registry


def members(text: str, name: str = "Foo") -> tuple[list[str], dict[str, str | None]]:
    """Return the names of the fields, and the names of the constants with their aliases."""
    names = name_members(parse_message(text, package="pkg", name=name))
    return list(names.fields), {each.name: each.alias for each in names.constants}


@pytest.mark.parametrize(
    ("package", "namespace"),
    [
        ("std_msgs", "std_msgs"),
        ("class", "class_"),
        ("unix", "unix_"),
        ("time", "time_"),
        ("std", "std_"),
        ("my-robot", "my_robot"),
    ],
)
def test_namespaces(package: str, namespace: str) -> None:
    assert namespace_name(package) == namespace


@pytest.mark.parametrize(
    ("name", "cpp_class"), [("String", "String"), ("class", "class_"), ("HIGH", "HIGH_"), ("ros", "ros_")]
)
def test_classes(name: str, cpp_class: str) -> None:
    assert class_name(name) == cpp_class
    assert qualified_class(f"std_msgs/{name}") == f"::std_msgs::{cpp_class}"


def test_bundled_types_keep_all_their_names() -> None:
    registry = Registry()
    for name in registry.messages():
        spec = registry.message(name)
        assert namespace_name(spec.package) == spec.package
        assert class_name(spec.name) == spec.name
        names = name_members(spec)
        assert names.fields == tuple(field.name for field in spec.fields)
        assert [each.name for each in names.constants] == [constant.name for constant in spec.constants]


def test_no_two_types_share_a_guard() -> None:
    packages = ("a", "a_b", "a_B", "a_b_C", "b")
    types = ("C", "c", "b_C", "B_C", "b_c", "B_C_2", "C_H_", "C_H_2")
    guards = {include_guard(f"{package}/{name}") for package, name in itertools.product(packages, types)}
    assert len(guards) == len(packages) * len(types)
    assert include_guard("sensor_msgs/Range") == "ROS_sensor_msgs_Range_H_"


@pytest.mark.parametrize(
    ("field", "name"),
    [
        ("data", "data"),
        ("fields", "fields"),
        ("class", "class_"),
        ("and", "and_"),
        ("HIGH", "HIGH_"),
        ("B1", "B1_"),
        ("stdin", "stdin_"),
        ("errno", "errno"),
        ("ERROR", "ERROR_"),
        ("serialize", "serialize_"),
        ("getType", "getType_"),
        ("Foo", "Foo_"),
        ("uint8_t", "uint8_t_"),
        # Macros with arguments do not change them, and sketches have fields that are macros only on a PC.
        ("min", "min"),
        ("F", "F"),
        ("near", "near"),
        ("linux", "linux"),
        ("ros", "ros"),
    ],
)
def test_a_field_has_its_name_unless_no_sketch_could_use_it(field: str, name: str) -> None:
    assert members(f"uint8 {field}") == ([name], {})


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("uint8 class\nuint8 class_", ["class__", "class_"]),
        ("uint8 x_length\nuint8[] x", ["x_length_", "x"]),
        ("uint8[] x_length\nuint8[] x", ["x_length_", "x"]),
        ("uint8[] new\nuint8 new__length", ["new__", "new__length"]),
        ("uint8[3] x\nuint8 x_length", ["x", "x_length"]),
    ],
)
def test_no_two_members_share_a_name(text: str, names: list[str]) -> None:
    assert members(text)[0] == names


@pytest.mark.parametrize(
    ("text", "constants"),
    [
        ("uint8 RED=1", {"RED": None}),
        ("uint8 HIGH=1", {"HIGH": "HIGH_"}),
        ("uint8 HIGH=1\nuint8 HIGH_", {"HIGH": "HIGH__"}),
        ("uint8 B101=5", {"B101": "B101_"}),
        ("uint8 NO_ERROR=0", {"NO_ERROR": "NO_ERROR_"}),
        ("string class=a", {"class_": None}),
        ("uint8 x=1\nuint8 x", {"x_": None}),
        ("uint8 _x_type=1\nuint8 x", {"_x_type_": None}),
        ("uint8 _fields=1", {"_fields_": None}),
        ("uint8 A=1\nuint8 B=2\nuint8 A=3", {"A": None, "B": None}),
    ],
)
def test_constants(text: str, constants: dict[str, str | None]) -> None:
    assert members(text)[1] == constants
