"""Creating and finding packages, compared with catkin and rospack."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from interop.ros1_peers import DEBIAN_PYTHON
from rostether.packages.locate import package_folders

pytestmark = pytest.mark.catkin

READ = """
import json, sys
from catkin_pkg.package import parse_package
package = parse_package(sys.argv[1])
package.validate()
kinds = ("buildtool_depends", "build_depends", "build_export_depends", "exec_depends")
print(json.dumps({
    "name": package.name, "version": package.version, "description": package.description,
    "format": package.package_format, "licenses": sorted(str(each) for each in package.licenses),
    "maintainers": [each.email for each in package.maintainers],
    "authors": [[each.name, each.email] for each in package.authors],
    "exports": [each.tagname for each in package.exports],
    **{kind: sorted(each.name for each in getattr(package, kind)) for kind in kinds},
}))
"""


def read(package: Path) -> dict[str, object]:
    completed = subprocess.run(
        [DEBIAN_PYTHON, "-c", READ, str(package / "package.xml")], capture_output=True, text=True, check=True
    )
    result: dict[str, object] = json.loads(completed.stdout)
    return result


def files(package: Path) -> set[str]:
    return {str(each.relative_to(package)) for each in package.rglob("*")}


@pytest.mark.parametrize(
    "arguments",
    [
        ["mearm_model", "std_msgs", "rospy", "roscpp", "rosserial_arduino", "rosserial_client"],
        ["empty"],
        ["scripts_only", "rospy"],
        ["all_of_it", "arm", "leg", "--meta"],
        ["arm", "-V", "1.2.3", "-D", "An arm and more", "-l", "MIT", "-l", "BSD", "-m", "Ada", "-a", "Bob"],
        ["leg", "roscpp", "std_msgs", "std_msgs"],
    ],
)
def test_a_new_package_equals_that_of_catkin_create_pkg(tmp_path: Path, arguments: list[str]) -> None:
    debian, rostether = tmp_path / "debian", tmp_path / "rostether"
    for folder, command in (
        (debian, ["catkin_create_pkg"]),
        (rostether, [sys.executable, "-m", "rostether", "pkg", "create"]),
    ):
        folder.mkdir()
        subprocess.run([*command, *arguments], cwd=folder, capture_output=True, check=True)
    name = arguments[0]
    described, expected = read(rostether / name), read(debian / name)
    if "--meta" in arguments:
        # catkin's rules for metapackages, which its tool breaks: they have only run dependencies.
        for kind in ("build_depends", "build_export_depends"):
            described.pop(kind)
            expected.pop(kind)
    assert described == expected
    assert files(rostether / name) == files(debian / name)


def test_rospack_finds_the_same_packages(tmp_path: Path) -> None:
    for path, ignored in (
        ("one/arm", False),
        ("one/stack/deep/leg", False),
        ("one/arm/inner", False),
        ("one/ignored/hand", True),
        ("two/arm", False),
        ("two/foot", False),
    ):
        folder = tmp_path / path
        folder.mkdir(parents=True)
        text = (
            f'<package format="2"><name>{folder.name}</name><version>1.0.0</version>'
            '<description>d</description><maintainer email="a@b.c">a</maintainer>'
            "<license>MIT</license></package>"
        )
        (folder / "package.xml").write_text(text)
        if ignored:
            (folder.parent / "CATKIN_IGNORE").touch()
    path = f"{tmp_path / 'one'}:{tmp_path / 'two'}"
    environ = {
        "PATH": "/usr/bin:/bin",
        "HOME": str(tmp_path / "home"),
        "ROS_PACKAGE_PATH": path,
        "ROS_ROOT": "/nowhere",
    }
    shown = subprocess.run(
        ["rospack", "list"], env=environ, capture_output=True, text=True, check=True
    ).stdout
    # Debian's rospack also searches the packages of the system.
    debian = {name: folder for name, folder in _pairs(shown) if folder.startswith(str(tmp_path))}
    assert {
        name: str(folder) for name, folder in package_folders(environ, tmp_path / "home").items()
    } == debian


def _pairs(shown: str) -> list[tuple[str, str]]:
    return [(line.split(" ", 1)[0], line.split(" ", 1)[1]) for line in shown.splitlines()]
