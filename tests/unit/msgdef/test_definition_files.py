from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.definition_files import (
    MAX_LISTED_PACKAGES,
    Kind,
    PackageFiles,
    bundled_file,
    bundled_names,
    bundled_packages,
    earlier_files,
    find_definitions,
    read_definition,
)
from rostether.msgdef.parse_msg import MAX_TEXT_CHARACTERS


def write(root: Path, *files: str) -> Path:
    for file in files:
        path = root / file
        path.parent.mkdir(parents=True, exist_ok=True)
        name = path.parent.name
        path.write_text(
            f"<package><name>{name}</name></package>" if file.endswith("package.xml") else "int8 x\n"
        )
    return root


def listed(found: Mapping[str, PackageFiles]) -> dict[str, set[str]]:
    return {
        package: {f"{name}.{kind}" for kind in Kind for name in files.of(kind)}
        for package, files in found.items()
    }


@pytest.mark.parametrize(
    "layout", ["{p}/Foo.msg", "{p}/msg/Foo.msg", "deep/er/{p}/msg/Foo.msg", "src/{p}/Foo.msg"]
)
def test_plain_folders_are_packages_by_their_name(tmp_path: Path, layout: str) -> None:
    write(tmp_path, layout.format(p="my_msgs"))
    assert listed(find_definitions([tmp_path], [])) == {"my_msgs": {"Foo.msg"}}


def test_the_given_folder_can_be_the_package_or_its_msg_folder(tmp_path: Path) -> None:
    write(tmp_path, "my_msgs/msg/Foo.msg", "my_msgs/srv/Bar.srv")
    both = {"my_msgs": {"Foo.msg", "Bar.srv"}}
    assert listed(find_definitions([tmp_path / "my_msgs"], [])) == both
    assert listed(find_definitions([tmp_path / "my_msgs" / "msg"], [])) == {"my_msgs": {"Foo.msg"}}


def test_the_given_msg_folder_of_a_real_package_has_that_packages_name(tmp_path: Path) -> None:
    write(tmp_path, "checkout/msg/Foo.msg")
    (tmp_path / "checkout" / "package.xml").write_text("<package><name>real_msgs</name></package>")
    assert listed(find_definitions([tmp_path / "checkout" / "msg"], [])) == {"real_msgs": {"Foo.msg"}}
    assert listed(find_definitions([tmp_path], [])) == {"real_msgs": {"Foo.msg"}}


def test_a_relative_path_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "my_msgs/Foo.msg")
    monkeypatch.chdir(tmp_path / "my_msgs")
    assert listed(find_definitions([Path()], [])) == {"my_msgs": {"Foo.msg"}}


def test_packages_of_a_workspace_have_all_three_kinds(tmp_path: Path) -> None:
    write(
        tmp_path,
        "src/repo/robot_msgs/package.xml",
        "src/repo/robot_msgs/msg/A.msg",
        "src/repo/robot_msgs/msg/nested/B.msg",
        "src/repo/robot_msgs/srv/C.srv",
        "src/repo/robot_msgs/action/D.action",
        "src/repo/robot_msgs/E.msg",
        "src/repo/robot_msgs/test/F.msg",
        "src/repo/robot_msgs/msg/README.md",
        "src/repo/robot_msgs/msg/not-a-type.msg",
    )
    expected = {"robot_msgs": {"A.msg", "B.msg", "C.srv", "D.action", "E.msg"}}
    assert listed(find_definitions([tmp_path], [])) == expected
    assert listed(find_definitions([], [tmp_path])) == expected


def test_on_ros_package_path_only_packages_count(tmp_path: Path) -> None:
    write(tmp_path, "loose/Foo.msg", "real/package.xml", "real/msg/Foo.msg")
    assert listed(find_definitions([], [tmp_path])) == {"real": {"Foo.msg"}}
    assert set(find_definitions([tmp_path], [])) == {"loose", "real"}


def test_the_first_root_has_priority_and_others_add_types(tmp_path: Path) -> None:
    write(tmp_path, "one/my_msgs/A.msg", "two/my_msgs/A.msg", "two/my_msgs/B.msg")
    found = find_definitions([tmp_path / "one", tmp_path / "two"], [])["my_msgs"].of(Kind.MESSAGE)
    assert dict(found) == {
        "A": tmp_path / "one" / "my_msgs" / "A.msg",
        "B": tmp_path / "two" / "my_msgs" / "B.msg",
    }


def test_a_broken_package_xml_does_not_hide_definitions_that_the_user_names(tmp_path: Path) -> None:
    write(tmp_path, "my_msgs/msg/Foo.msg")
    (tmp_path / "my_msgs" / "package.xml").write_text("<package>")
    assert listed(find_definitions([tmp_path], [])) == {"my_msgs": {"Foo.msg"}}
    assert find_definitions([], [tmp_path]) == {}


def test_folders_that_are_not_package_names_are_skipped(tmp_path: Path) -> None:
    write(tmp_path, "no name/Foo.msg", "1st/Foo.msg")
    assert find_definitions([tmp_path, tmp_path / "missing"], []) == {}


def test_a_text_may_have_any_line_ends_byte_order_mark_and_encoding(tmp_path: Path) -> None:
    file = tmp_path / "Foo.msg"
    file.write_bytes(b"\xef\xbb\xbfint8 a\r\nint8 b\rint8 c # \xb5m\n")
    assert read_definition(file) == "int8 a\nint8 b\nint8 c # �m\n"


def test_a_text_that_cannot_be_read_is_an_error_with_its_file(tmp_path: Path) -> None:
    with pytest.raises(DefinitionError, match=r"Foo\.msg: cannot be read: No such file"):
        read_definition(tmp_path / "Foo.msg")
    with pytest.raises(DefinitionError, match="is not a file with a definition; remove it"):
        read_definition(tmp_path)
    large = tmp_path / "Large.msg"
    large.write_bytes(b"#" * (MAX_TEXT_CHARACTERS + 1))
    with pytest.raises(DefinitionError, match="longer"):
        read_definition(large)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no FIFOs")
def test_a_fifo_is_refused_without_waiting_for_a_writer(tmp_path: Path) -> None:
    file = tmp_path / "Foo.msg"
    os.mkfifo(file)
    with pytest.raises(DefinitionError, match=r"Foo\.msg: is not a file with a definition; remove it"):
        read_definition(file)


def test_bundled_files_have_only_their_exact_names() -> None:
    assert {"std_msgs", "rosserial_msgs", "turtlebot3_msgs"} <= bundled_packages()
    file = bundled_file("std_msgs", Kind.MESSAGE, "String")
    assert file is not None
    assert file.read_text() == "string data\n"
    for package, name in [
        ("std_msgs", "string"),
        ("Std_msgs", "String"),
        ("..", "String"),
        ("std_msgs", "../String"),
    ]:
        assert bundled_file(package, Kind.MESSAGE, name) is None
    assert bundled_names("std_msgs", Kind.SERVICE) == frozenset()
    assert bundled_names("unknown", Kind.MESSAGE) == frozenset()


def test_names_that_a_board_invents_are_not_kept_forever() -> None:
    for number in range(2 * MAX_LISTED_PACKAGES):
        bundled_names(f"made_up_{number}", Kind.MESSAGE)
    assert bundled_names.cache_info().currsize <= MAX_LISTED_PACKAGES


def test_bundled_definitions_contain_no_prose() -> None:
    for package in bundled_packages():
        for kind in Kind:
            for name in bundled_names(package, kind):
                file = bundled_file(package, kind, name)
                assert file is not None
                assert all(line and "#" not in line for line in file.read_text().splitlines()), file


def test_earlier_versions_are_found_by_name() -> None:
    assert list(earlier_files("turtlebot3_msgs", "SensorState")) == ["0.1.4"]
    assert earlier_files("turtlebot3_msgs", "Sensor") == {}
    assert earlier_files("std_msgs", "String") == {}
    assert earlier_files("../std_msgs", "String") == {}
