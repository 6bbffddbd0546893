from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.packages.create import NewPackage, create_package, package_xml
from rostether.packages.package_xml import parse_package_xml


def test_the_files_of_a_package(tmp_path: Path) -> None:
    created = create_package(tmp_path, NewPackage("arm", ["std_msgs", "rospy", "roscpp"]))
    assert created.folder == tmp_path / "arm"
    assert created.files == [tmp_path / "arm" / "package.xml", tmp_path / "arm" / "CMakeLists.txt"]
    assert created.folders == [tmp_path / "arm" / "include" / "arm", tmp_path / "arm" / "src"]
    assert all(each.is_dir() for each in created.folders)
    assert created.warnings == []
    described = parse_package_xml(created.files[0].read_bytes())
    assert (described.name, described.version) == ("arm", "0.0.0")
    assert described.description == "The arm package"
    kinds = frozenset({"build_depend", "build_export_depend", "exec_depend"})
    assert described.dependencies == {
        "catkin": frozenset({"buildtool_depend"}),
        "roscpp": kinds,
        "rospy": kinds,
        "std_msgs": kinds,
    }
    cmake = created.files[1].read_text()
    assert "find_package(catkin REQUIRED COMPONENTS\n  roscpp\n  rospy\n  std_msgs\n)" in cmake
    assert "generate_messages(DEPENDENCIES std_msgs)" in cmake


def test_folders_depend_on_the_dependencies(tmp_path: Path) -> None:
    assert create_package(tmp_path, NewPackage("a")).folders == []
    assert create_package(tmp_path, NewPackage("b", ["rospy"])).folders == [tmp_path / "b" / "src"]
    assert create_package(tmp_path, NewPackage("c", ["roscpp"], is_metapackage=True)).folders == []


def test_texts_are_escaped() -> None:
    text = package_xml(
        NewPackage(
            "arm",
            description="<arms> & hands",
            licenses=["MIT", "BSD"],
            authors=["Ada & Co", "Bob <bob@example.org>"],
            maintainers=["Eve <eve@example.org>", "Mallory Malory"],
            user="me",
        )
    )
    described = parse_package_xml(text.encode())
    assert described.description == "<arms> & hands"
    assert described.licenses == ("MIT", "BSD")
    assert described.maintainers == ("Eve", "Mallory Malory")
    assert '<maintainer email="eve@example.org">Eve</maintainer>' in text
    assert '<maintainer email="Mallory.Malory@todo.todo">Mallory Malory</maintainer>' in text
    assert '<author email="bob@example.org">Bob</author>' in text
    assert "<author>Ada &amp; Co</author>" in text


def test_a_metapackage_only_names_other_packages() -> None:
    text = package_xml(NewPackage("all_of_it", ["arm"], is_metapackage=True))
    assert "<metapackage/>" in text
    assert parse_package_xml(text.encode()).dependencies["arm"] == frozenset({"exec_depend"})


def test_existing_files_are_not_overwritten(tmp_path: Path) -> None:
    create_package(tmp_path, NewPackage("arm"))
    (tmp_path / "arm" / "package.xml").write_text("mine")
    with pytest.raises(ConfigError, match="already exists"):
        create_package(tmp_path, NewPackage("arm"))
    assert (tmp_path / "arm" / "package.xml").read_text() == "mine"


@pytest.mark.parametrize("name", ["9x", "a/b", "../a", "", "-x", "ä"])
def test_invalid_names_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match="is not a package name"):
        create_package(tmp_path, NewPackage(name))
    with pytest.raises(ConfigError, match="is not a package name"):
        create_package(tmp_path, NewPackage("arm", [name]))
    assert list(tmp_path.iterdir()) == []


def test_unconventional_names_cause_a_warning(tmp_path: Path) -> None:
    assert "lower case" in create_package(tmp_path, NewPackage("MyArm")).warnings[0]


def test_a_version_has_three_numbers(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="three numbers"):
        create_package(tmp_path, NewPackage("arm", version="1.0"))
