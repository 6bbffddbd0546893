from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.errors import ConfigError, RobotModelError
from rostether.robot import xacro as xacro_module
from rostether.robot.urdf import parse_urdf
from rostether.robot.xacro import expand_xacro, is_xacro, parse_mappings, xacro_dependencies

MAIN = """<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find parts)/wheel.xacro"/>
  <xacro:arg name="count" default="2"/>
  <link name="base"/>
  <xacro:if value="${int('$(arg count)') > 1}"><xacro:wheel name="left" at="${pi/2}"/></xacro:if>
  <xacro:wheel name="right" at="1"/>
</robot>"""

WHEEL = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="wheel" params="name at">
    <link name="${name}"/>
    <joint name="${name}_joint" type="continuous"><parent link="base"/><child link="${name}"/>
      <origin xyz="0 0 ${at}"/></joint>
  </xacro:macro>
</robot>"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "wheel.xacro").write_text(WHEEL)
    file = tmp_path / "robot.xacro"
    file.write_text(MAIN)
    return file


def expand(file: Path, **mappings: str) -> str:
    return expand_xacro(file, mappings, packages={"parts": file.parent / "parts"})


def test_macros_arguments_and_find(robot: Path) -> None:
    model = parse_urdf(expand(robot))
    assert model.links == ("base", "left", "right")
    assert model.joints["left_joint"].origin.translation[2] == pytest.approx(1.5707963)
    assert parse_urdf(expand(robot, count="1")).links == ("base", "right")


def test_dependencies(robot: Path) -> None:
    found = xacro_dependencies(robot, {}, packages={"parts": robot.parent / "parts"})
    assert found == [str(robot.parent / "parts" / "wheel.xacro")]


def test_errors_name_a_missing_package(robot: Path) -> None:
    with pytest.raises(RobotModelError, match="no package parts on ROS_PACKAGE_PATH"):
        expand_xacro(robot, {}, packages={})


@pytest.mark.parametrize(
    ("inside", "reported"),
    [
        ('<link name="${nothing}"/>', "nothing"),
        ('<link name="${1/0}"/>', "zero"),
        ("<xacro:nowhere/>", "nowhere"),
        ('<xacro:include filename="no.xacro"/>', "no.xacro: No such file or directory; check the path"),
        ('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>', "endlessly"),
        ("<link", "not XML"),
    ],
)
def test_errors_are_one_line_with_the_file(tmp_path: Path, inside: str, reported: str) -> None:
    file = tmp_path / "wrong.xacro"
    file.write_text(f'<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>')
    with pytest.raises(RobotModelError) as refusal:
        expand(file)
    assert reported in str(refusal.value)
    assert "wrong.xacro" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_only_utf8_is_read(tmp_path: Path) -> None:
    file = tmp_path / "a.xacro"
    file.write_text('<?xml version="1.0" encoding="latin-1"?><robot name="ä"/>', encoding="latin-1")
    with pytest.raises(RobotModelError, match=r"a\.xacro: not UTF-8 text at byte 53; save it as UTF-8$"):
        expand(file)


def test_a_dtd_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "bomb.xacro"
    file.write_text('<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>')
    with pytest.raises(RobotModelError, match="DTD"):
        expand(file)
    outer = tmp_path / "outer.xacro"
    outer.write_text(
        '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="bomb.xacro"/></robot>'
    )
    with pytest.raises(RobotModelError, match=r"bomb.xacro:1: .*DTD"):
        expand(outer)


def test_endless_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xacro_module, "MAX_XML_BYTES", 1000)
    monkeypatch.setattr(xacro_module, "MAX_TEXT_CHARS", 1000)
    file = tmp_path / "endless.xacro"
    file.symlink_to("/dev/zero")
    with pytest.raises(RobotModelError, match="not XML"):
        expand(file)
    file = tmp_path / "values.xacro"
    file.write_text(
        '<robot name="${xacro.load_yaml(\'/dev/zero\')}" xmlns:xacro="http://www.ros.org/wiki/xacro"/>'
    )
    with pytest.raises(RobotModelError, match="unacceptable character"):
        expand(file)


def test_the_error_without_the_package_names_the_extra(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(RobotModelError, match=r"pip install 'rostether\[robot\]'"):
        expand(robot)


def test_mappings() -> None:
    assert parse_mappings(["a:=1", "b:=x:=y", "c:="]) == {"a": "1", "b": "x:=y", "c": ""}
    with pytest.raises(ConfigError, match="write name:=value"):
        parse_mappings(["a=1"])


def test_xacro_is_recognized() -> None:
    assert is_xacro(MAIN.encode())
    assert not is_xacro(b'<robot name="x"/>')


def doubling(levels: int) -> str:
    macros = ['<xacro:macro name="m0"><link/></xacro:macro>']
    macros += [
        f'<xacro:macro name="m{level}"><xacro:m{level - 1}/><xacro:m{level - 1}/></xacro:macro>'
        for level in range(1, levels)
    ]
    namespace = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    return f'<robot name="x" {namespace}>{"".join(macros)}<xacro:m{levels - 1}/></robot>'


def test_expansions_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.robot.xacro.MAX_ELEMENTS", 1000)
    file = tmp_path / "robot.xacro"
    file.write_text(doubling(5))
    assert expand_xacro(file, {}, packages={}).count("<link/>") == 16
    file.write_text(doubling(40))
    with pytest.raises(RobotModelError, match=r"robot\.xacro expands to more than 1000 elements; simplify"):
        expand_xacro(file, {}, packages={})


def test_properties_that_double_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.robot.xacro.MAX_CHARACTERS", 10_000)
    file = tmp_path / "robot.xacro"
    properties = "".join(
        f'<xacro:property name="p{level}" value="${{p{level - 1}}}${{p{level - 1}}}"/>'
        for level in range(1, 40)
    )
    file.write_text(
        '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="p0" value="xx"/>'
        f'{properties}<link name="${{p39}}"/></robot>'
    )
    with pytest.raises(RobotModelError, match="expands to more than 10000 characters; shorten"):
        expand_xacro(file, {}, packages={})
