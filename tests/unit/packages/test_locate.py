from __future__ import annotations

import os
from pathlib import Path

import pytest

from rostether.packages.locate import (
    installed_packages,
    package_around,
    package_folders,
    package_roots,
    workspace_of,
)


def make_package(folder: Path, name: str = "") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name>{name or folder.name}</name></package>")
    return folder


def test_packages_below_the_current_folder_are_found(tmp_path: Path) -> None:
    arm = make_package(tmp_path / "robots" / "arm")
    assert package_folders({}, tmp_path) == {"arm": arm}


def test_ros_package_path_has_priority_over_the_workspace_and_the_current_folder(tmp_path: Path) -> None:
    first = make_package(tmp_path / "first" / "arm")
    make_package(tmp_path / "second" / "arm")
    make_package(tmp_path / "ws" / "src" / "arm")
    path = os.pathsep.join([str(tmp_path / "first"), str(tmp_path / "second"), str(tmp_path / "missing")])
    assert package_folders({"ROS_PACKAGE_PATH": path}, tmp_path / "ws") == {"arm": first}


def test_a_relative_ros_package_path_is_relative_to_the_current_folder(tmp_path: Path) -> None:
    arm = make_package(tmp_path / "here" / "packages" / "arm")
    roots = package_roots({"ROS_PACKAGE_PATH": "packages"}, tmp_path / "here")
    assert roots[0] == arm.parent


def test_the_workspace_src_has_priority_over_other_folders(tmp_path: Path) -> None:
    make_package(tmp_path / "old" / "arm")
    new = make_package(tmp_path / "src" / "arm")
    assert package_folders({}, tmp_path) == {"arm": new}


@pytest.mark.parametrize(
    "mark", [".catkin_workspace", ".catkin_tools", "src/CMakeLists.txt", "devel/.catkin"]
)
def test_the_workspace_is_found_from_any_folder_inside(tmp_path: Path, mark: str) -> None:
    arm = make_package(tmp_path / "ws" / "src" / "stack" / "arm")
    leg = make_package(tmp_path / "ws" / "src" / "leg")
    (tmp_path / "ws" / mark).parent.mkdir(exist_ok=True)
    (tmp_path / "ws" / mark).touch()
    build = tmp_path / "ws" / "build" / "deep"
    build.mkdir(parents=True)
    for cwd in [build, arm, leg.parent, tmp_path / "ws"]:
        assert workspace_of(cwd) == tmp_path / "ws"
        assert package_folders({}, cwd) == {"arm": arm, "leg": leg}


def test_an_unmarked_workspace_is_recognized_by_its_src(tmp_path: Path) -> None:
    arm = make_package(tmp_path / "ws" / "src" / "arm")
    leg = make_package(tmp_path / "ws" / "src" / "leg")
    scripts = arm / "scripts"
    scripts.mkdir()
    assert workspace_of(scripts) == tmp_path / "ws"
    assert package_folders({}, scripts) == {"arm": arm, "leg": leg}


def test_a_packages_own_src_is_not_a_workspace(tmp_path: Path) -> None:
    arm = make_package(tmp_path / "arm")
    (arm / "src").mkdir()
    (arm / "src" / "CMakeLists.txt").touch()
    assert workspace_of(arm / "src") is None


def test_without_a_workspace_the_package_around_and_its_neighbors_are_found(tmp_path: Path) -> None:
    arm = make_package(tmp_path / "checkout" / "arm_folder", "arm")
    leg = make_package(tmp_path / "checkout" / "leg")
    make_package(tmp_path / "elsewhere" / "hand")
    launch = arm / "launch"
    launch.mkdir()
    assert package_around(launch) == arm
    assert package_folders({}, launch) == {"arm": arm, "leg": leg}


def test_an_empty_folder_has_no_packages(tmp_path: Path) -> None:
    assert package_folders({"ROS_PACKAGE_PATH": ""}, tmp_path) == {}


def test_installed_packages_of_the_first_prefix_have_priority(tmp_path: Path) -> None:
    for prefix, name in (("over", "arm"), ("under", "arm"), ("under", "base")):
        make_package(tmp_path / prefix / "share" / name)
    (tmp_path / "under/share/doc").mkdir()
    found = installed_packages([tmp_path / "over", tmp_path / "missing", tmp_path / "under"])
    assert found == {"arm": tmp_path / "over/share/arm", "base": tmp_path / "under/share/base"}
