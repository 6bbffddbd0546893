from __future__ import annotations

import os
from pathlib import Path

import pytest

from rostether.packages import search_path
from rostether.packages.search_path import find_packages, ros_package_path, walk


def make_package(folder: Path, name: str = "") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name>{name or folder.name}</name></package>")
    return folder


def test_packages_are_found_at_any_depth(tmp_path: Path) -> None:
    one = make_package(tmp_path / "src" / "one")
    two = make_package(tmp_path / "src" / "stack" / "group" / "two")
    assert find_packages([tmp_path]) == {"one": one, "two": two}


def test_a_root_can_be_a_package_itself(tmp_path: Path) -> None:
    one = make_package(tmp_path / "folder", "one")
    assert find_packages([one]) == {"one": one}


def test_the_first_root_has_priority_then_the_nearest_folder(tmp_path: Path) -> None:
    first = make_package(tmp_path / "overlay" / "deep" / "er" / "robot")
    make_package(tmp_path / "underlay" / "robot")
    assert find_packages([tmp_path / "overlay", tmp_path / "underlay"]) == {"robot": first}
    near = make_package(tmp_path / "both" / "z", "twice")
    make_package(tmp_path / "both" / "a" / "b", "twice")
    assert find_packages([tmp_path / "both"]) == {"twice": near}


def test_duplicate_names_are_reported_unless_overlays_or_copies(tmp_path: Path) -> None:
    reported: list[tuple[str, Path, Path]] = []

    def note(*what: object) -> None:
        reported.append(what)  # type: ignore[arg-type]

    used = make_package(tmp_path / "ws" / "src" / "robot")
    other = make_package(tmp_path / "ws" / "old" / "robot")
    copy = make_package(tmp_path / "ws" / "install" / "share" / "robot")
    (copy.parents[1] / ".catkin").touch()
    make_package(tmp_path / "overlay" / "robot")
    find_packages([tmp_path / "overlay", tmp_path / "ws" / "src"], on_duplicate=note)
    assert reported == []
    found = find_packages([tmp_path / "ws" / "src", tmp_path / "ws"], on_duplicate=note)
    assert found == {"robot": used}
    assert reported == [("robot", used, other)]


def test_nothing_is_searched_below_a_package(tmp_path: Path) -> None:
    outer = make_package(tmp_path / "outer")
    make_package(outer / "inner")
    assert find_packages([tmp_path]) == {"outer": outer}


def test_ignored_and_hidden_folders_are_skipped(tmp_path: Path) -> None:
    make_package(tmp_path / "ignored" / "a")
    (tmp_path / "ignored" / "CATKIN_IGNORE").touch()
    make_package(tmp_path / ".git" / "b")
    make_package(tmp_path / "__pycache__" / "d")
    make_package(tmp_path / "flat" / "deep" / "c")
    (tmp_path / "flat" / "rospack_nosubdirs").touch()
    assert find_packages([tmp_path]) == {}


def test_rosbuild_manifests_count(tmp_path: Path) -> None:
    folder = tmp_path / "old_robot"
    folder.mkdir()
    (folder / "manifest.xml").write_text("<package/>")
    assert find_packages([tmp_path]) == {"old_robot": folder}


def test_a_broken_package_does_not_hide_the_others(tmp_path: Path) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "package.xml").write_text("<package><name>")
    good = make_package(tmp_path / "good")
    assert find_packages([tmp_path, tmp_path / "missing"]) == {"good": good}


def test_link_loops_end(tmp_path: Path) -> None:
    package = make_package(tmp_path / "src" / "one")
    (tmp_path / "src" / "again").symlink_to(tmp_path)
    linked = make_package(tmp_path / "elsewhere" / "two")
    (tmp_path / "src" / "two").symlink_to(linked)
    assert set(find_packages([tmp_path / "src"])) == {"one", "two"}
    assert find_packages([tmp_path / "src"])["one"] == package


def test_depth_and_number_of_folders_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_package(tmp_path.joinpath(*"abcd", "deep"))
    monkeypatch.setattr(search_path, "MAX_DEPTH", 4)
    assert find_packages([tmp_path]) == {}
    monkeypatch.setattr(search_path, "MAX_DEPTH", 5)
    assert set(find_packages([tmp_path])) == {"deep"}
    monkeypatch.setattr(search_path, "MAX_FOLDERS", 3)
    assert len(list(walk(tmp_path))) == 3


def test_only_the_top_level_of_a_system_share_folder_is_searched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    top = make_package(tmp_path / "std_msgs")
    make_package(tmp_path / "doc" / "examples" / "robot")
    monkeypatch.setattr(search_path, "SYSTEM_SHARE_FOLDERS", {str(tmp_path)})
    assert find_packages([tmp_path]) == {"std_msgs": top}


def test_walk_can_go_below_packages(tmp_path: Path) -> None:
    make_package(tmp_path / "outer")
    make_package(tmp_path / "outer" / "inner")
    names = [folder.path.name for folder in walk(tmp_path, below_packages=True)]
    assert names == [tmp_path.name, "outer", "inner"]


def test_ros_package_path_is_split() -> None:
    path = os.pathsep.join(["/a", "", "/b c"])
    assert ros_package_path({"ROS_PACKAGE_PATH": path}) == [Path("/a"), Path("/b c")]
    assert ros_package_path({}) == []
