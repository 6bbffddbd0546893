from __future__ import annotations

from pathlib import Path

import pytest

from unit.cli.command_shell import Shell
from unit.robot.robots import ARM, GRIPPER


@pytest.fixture
def arm(tmp_path: Path) -> str:
    file = tmp_path / "arm.urdf"
    file.write_text(ARM)
    return str(file)


@pytest.fixture
def wheels(tmp_path: Path) -> str:
    file = tmp_path / "wheels.xacro"
    file.write_text(
        '<robot name="w" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="n" default="a"/>'
        '<link name="$(arg n)"/></robot>'
    )
    return str(file)


def test_check_shows_the_tree_of_links(arm: str, shell: Shell) -> None:
    assert shell.output("urdf", "check", arm).splitlines() == [
        "robot name is: arm",
        "---------- Successfully Parsed XML ---------------",
        "root Link: base has 1 child(ren)",
        "    child(1):  turret",
        "        child(1):  upper",
        "            child(1):  fore",
        "                child(1):  hand",
    ]


def test_check_reports_errors(tmp_path: Path, shell: Shell) -> None:
    file = tmp_path / "wrong.urdf"
    file.write_text('<robot name="x">\n<link name="a"/>\n<link name="b"/></robot>')
    assert shell.failure("urdf", "check", str(file)) == (
        f"{file}:1: two root links, 'a' and 'b'; connect them with a joint"
    )
    file.write_text('<robot name="x"><link name="a"><visual/></link></robot>')
    assert f"skipped: {file}:1: visual of link 'a' has no geometry" in shell("urdf", "check", str(file)).err


def test_check_warns_of_probable_mistakes(tmp_path: Path, shell: Shell) -> None:
    file = tmp_path / "doubtful.urdf"
    file.write_text(
        '<robot name="x"><link name="a"/><link name="b"/><joint name="j" type="prismatic"><parent link="a"/>'
        '<child link="b"/><limit lower="2" upper="1" effort="1" velocity="1"/><mimic joint="k"/></joint>'
        "</robot>"
    )
    result = shell("urdf", "check", str(file))
    assert result.code == 0
    assert result.err == (
        "WARNING: joint j: its lower limit 2 is above its upper limit 1; exchange them\n"
        "WARNING: joint j: it mimics 'k', which does not exist; correct the name\n"
    )


def test_a_chain_of_thousands_of_links_fills_no_disk(tmp_path: Path, shell: Shell) -> None:
    file = tmp_path / "chain.urdf"
    links = "".join(f'<link name="l{place}"/>' for place in range(2001))
    joints = "".join(
        f'<joint name="j{place}" type="fixed"><parent link="l{place}"/><child link="l{place + 1}"/></joint>'
        for place in range(2000)
    )
    file.write_text(f'<robot name="chain">{links}{joints}</robot>')
    for verb in ("check", "tree"):
        text = shell.output("urdf", verb, str(file))
        assert "l2000" in text
        assert len(text) < 1_000_000


def test_tree_names_joints(tmp_path: Path, arm: str, shell: Shell) -> None:
    assert shell.output("urdf", "tree", arm).splitlines()[:2] == [
        "base",
        "└─ turret  (j0: revolute, -85.94° to 143.2°)",
    ]
    file = tmp_path / "gripper.urdf"
    file.write_text(GRIPPER)
    text = shell.output("urdf", "tree", str(file))
    assert "slide  (lift: prismatic, 0.02 m to 0.2 m)" in text
    assert "tip  (tip: continuous, follows right)" in text
    records = {each["joint"]: each for each in shell("urdf", "tree", "--json", str(file)).records}
    assert records["right"]["mimics"] == "left"


def test_xacro_is_expanded_first(wheels: str, shell: Shell) -> None:
    assert shell.output("urdf", "tree", wheels) == "a\n"
    assert shell.output("urdf", "tree", wheels, "n:=b") == "b\n"


def test_xacro_as_typed_for_xacro(wheels: str, tmp_path: Path, shell: Shell) -> None:
    assert '<link name="c"/>' in shell.output("xacro", "--inorder", wheels, "n:=c")
    output = tmp_path / "made" / "w.urdf"
    assert shell.output("xacro", wheels, "-o", str(output)) == ""
    assert '<link name="a"/>' in output.read_text()
    assert shell.output("xacro", "--deps", wheels) == "\n"
    assert "give a file in this folder" in shell.failure("xacro", wheels, "-o", str(tmp_path))
