from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.packages.package_xml import (
    MAX_PACKAGE_XML_BYTES,
    PackageXml,
    is_package_name,
    parse_package_xml,
)

FULL = b"""<?xml version="1.0"?>
<package format="2">
  <name> my_robot </name>
  <version>1.2.3</version>
  <description>Wheels, <b>arms</b>
     and eyes.</description>
  <maintainer email="a@b.c">Ada</maintainer>
  <maintainer email="d@e.f">Dan</maintainer>
  <license>BSD</license>
  <buildtool_depend>catkin</buildtool_depend>
  <depend>std_msgs</depend>
  <exec_depend version_gte="1">roscpp</exec_depend>
  <run_depend>std_msgs</run_depend>
  <export><build_type>catkin</build_type><rosdoc config="x"/></export>
</package>
"""


def test_a_package_xml_is_read() -> None:
    assert parse_package_xml(FULL) == PackageXml(
        name="my_robot",
        version="1.2.3",
        description="Wheels, arms and eyes.",
        maintainers=("Ada", "Dan"),
        licenses=("BSD",),
        dependencies={
            "catkin": frozenset({"buildtool_depend"}),
            "std_msgs": frozenset({"depend", "run_depend"}),
            "roscpp": frozenset({"exec_depend"}),
        },
        build_type="catkin",
    )


def test_a_rosbuild_manifest_has_the_name_of_its_folder() -> None:
    manifest = b"<package><description>old</description><depend package='roscpp'/></package>"
    parsed = parse_package_xml(manifest, file="manifest.xml", default_name="old_robot")
    assert parsed.name == "old_robot"
    assert parsed.dependencies == {"roscpp": frozenset({"depend"})}


BOMB = b"""<!DOCTYPE lolz [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;&a;">]>
<package><name>&b;</name></package>"""


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "empty, so it is not a package.xml"),
        (b"<package><name>a</name>", "not XML"),
        (b"<package/>", "has no name; add <name>"),
        (b"<package><name>1a</name></package>", "not a package name"),
        (b"<package><name>a/b</name></package>", "not a package name"),
        (b"<robot><name>a</name></robot>", "<robot>, not <package>"),
        (BOMB, "DTD"),
        (b"<!DOCTYPE package SYSTEM 'file:///etc/passwd'><package><name>a</name></package>", "DTD"),
        (b"<package><name>&undefined;</name></package>", "not XML"),
        (b"<package>" + b"<a>" * 100 + b"</a>" * 100 + b"</package>", "deeper"),
        (b" " * (MAX_PACKAGE_XML_BYTES + 1), "larger"),
        (b"\xff\xfe\x00", "not XML"),
    ],
)
def test_invalid_texts_are_refused_in_one_line(data: bytes, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason) as raised:
        parse_package_xml(data, file="x/package.xml")
    assert str(raised.value).startswith("x/package.xml:")
    assert "\n" not in str(raised.value)


def test_errors_name_the_line() -> None:
    with pytest.raises(ConfigError, match=r"package\.xml:3:"):
        parse_package_xml(b"<package>\n<name>a</name>\n<oops></package>")


@pytest.mark.parametrize(
    ("name", "legal"), [("a", True), ("my-robot_2", True), ("_a", False), ("a b", False)]
)
def test_package_names(name: str, legal: bool) -> None:
    assert is_package_name(name) is legal
