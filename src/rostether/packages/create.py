"""Creates a package like catkin_create_pkg, so that it also builds with a real ROS.

    NAME/package.xml
    NAME/CMakeLists.txt
    NAME/include/NAME/   with the dependency roscpp
    NAME/src/            with the dependency roscpp or rospy

The dependencies determine which build lines are active. The lines for messages and services are comments.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.mechanisms.text import write_failure
from rostether.packages.package_xml import PACKAGE_FILE, is_package_name

CMAKE_FILE = "CMakeLists.txt"
_CONVENTIONAL_NAME = re.compile(r"[a-z][a-z0-9_-]*")
_VERSION = re.compile(r"\d+\.\d+\.\d+")
_PERSON = re.compile(r"(.*?)\s*<([^<>\s]+@[^<>\s]+)>")

# A placeholder for the user's address, as in catkin_create_pkg.
_UNKNOWN_MAIL = "todo.todo"


class NewPackage(Struct, frozen=True):
    """The properties of a new package; `dependencies` are catkin packages, `system_dependencies` others."""

    name: str
    dependencies: Sequence[str] = ()
    system_dependencies: Sequence[str] = ()
    boost_components: Sequence[str] = ()
    version: str = "0.0.0"
    description: str = ""
    licenses: Sequence[str] = ()
    authors: Sequence[str] = ()
    maintainers: Sequence[str] = ()
    is_metapackage: bool = False
    user: str = "user"


class CreatedPackage(Struct, frozen=True):
    """The result of `create_package`: what was written, in order, and lines for the user."""

    folder: Path
    files: list[Path]
    folders: list[Path]
    warnings: list[str]


def create_package(parent: Path, package: NewPackage) -> CreatedPackage:
    """Write a package's folder below `parent`.

    Raises ConfigError for an invalid name or version, a file that already exists, or a folder that cannot be
    written.
    """
    _check(package)
    folder = parent / package.name
    texts = {folder / PACKAGE_FILE: package_xml(package), folder / CMAKE_FILE: cmake_lists(package)}
    for file in texts:
        if file.exists():
            raise ConfigError(f"{file} already exists; choose another name, or remove it")
    folders = []
    if not package.is_metapackage and "roscpp" in package.dependencies:
        folders.append(folder / "include" / package.name)
    if not package.is_metapackage and {"roscpp", "rospy"} & set(package.dependencies):
        folders.append(folder / "src")
    try:
        for each in (folder, *folders):
            each.mkdir(parents=True, exist_ok=True)
        for file, text in texts.items():
            file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(write_failure(error.filename, error)) from error
    warnings = []
    if not _CONVENTIONAL_NAME.fullmatch(package.name):
        warnings.append(
            f"{package.name}: package names should have only lower case letters, digits, _ and -, and start "
            "with a letter"
        )
    return CreatedPackage(folder, list(texts), folders, warnings)


def package_xml(package: NewPackage) -> str:
    """Return the text of a package.xml of format 2."""
    lines = [
        '<?xml version="1.0"?>',
        '<package format="2">',
        f"  <name>{package.name}</name>",
        f"  <version>{package.version}</version>",
        f"  <description>{escape(package.description or f'The {package.name} package')}</description>",
    ]
    maintainers = package.maintainers or [f"{package.user} <{package.user}@{_UNKNOWN_MAIL}>"]
    lines += [_person("maintainer", each) for each in maintainers]
    lines += [f"  <license>{escape(each)}</license>" for each in package.licenses or ["TODO"]]
    lines += [_person("author", each) for each in package.authors]
    lines += ["", "  <buildtool_depend>catkin</buildtool_depend>"]
    names = sorted({*package.dependencies, *package.system_dependencies})
    if package.is_metapackage:
        lines += [f"  <exec_depend>{each}</exec_depend>" for each in names]
        lines += ["", "  <export>", "    <metapackage/>", "  </export>"]
    else:
        for kind in ("build_depend", "build_export_depend", "exec_depend"):
            lines += [f"  <{kind}>{each}</{kind}>" for each in names]
        lines += [
            "  <!-- For messages and services of this package:",
            "  <build_depend>message_generation</build_depend>",
            "  <exec_depend>message_runtime</exec_depend>",
            "  -->",
        ]
    return "\n".join([*lines, "</package>", ""])


def cmake_lists(package: NewPackage) -> str:
    """Return the text of a CMakeLists.txt for catkin."""
    lines = ["cmake_minimum_required(VERSION 3.0.2)", f"project({package.name})", ""]
    if package.is_metapackage:
        return "\n".join([*lines, "find_package(catkin REQUIRED)", "catkin_metapackage()", ""])
    components = sorted(set(package.dependencies))
    lines += _call("find_package", "catkin REQUIRED" + (" COMPONENTS" if components else ""), components)
    if package.boost_components:
        lines.append(f"find_package(Boost REQUIRED COMPONENTS {' '.join(package.boost_components)})")
    lines += ["", "# Messages and services: name the files, and the packages whose types they contain."]
    messages = [each for each in components if each.endswith("_msgs")] or ["std_msgs"]
    for call in ("add_message_files(FILES Example.msg)", "add_service_files(FILES Example.srv)"):
        lines.append(f"# {call}")
    lines += [f"# generate_messages(DEPENDENCIES {' '.join(messages)})", ""]
    lines += _call("catkin_package", "CATKIN_DEPENDS" if components else "", components)
    if "roscpp" in components:
        lines += [
            "",
            "include_directories(include ${catkin_INCLUDE_DIRS})",
            f"# add_executable(${{PROJECT_NAME}}_node src/{package.name}_node.cpp)",
            "# target_link_libraries(${PROJECT_NAME}_node ${catkin_LIBRARIES})",
        ]
    if "rospy" in components:
        lines += [
            "",
            "# catkin_install_python(PROGRAMS scripts/node.py DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})",
        ]
    return "\n".join([*lines, ""])


def _call(name: str, first: str, rest: Sequence[str]) -> list[str]:
    return [f"{name}({first}", *(f"  {each}" for each in rest), ")"] if rest else [f"{name}({first})"]


def _person(tag: str, person: str) -> str:
    match = _PERSON.fullmatch(person)
    name, mail = (match[1], match[2]) if match else (person, f"{'.'.join(person.split())}@{_UNKNOWN_MAIL}")
    # Maintainers need an address, authors do not.
    email = f" email={quoteattr(mail)}" if match or tag == "maintainer" else ""
    return f"  <{tag}{email}>{escape(name)}</{tag}>"


def _check(package: NewPackage) -> None:
    for name in (package.name, *package.dependencies):
        if not is_package_name(name):
            raise ConfigError(f"{name!r} is not a package name; use a letter, then letters, digits, _ and -")
    if not _VERSION.fullmatch(package.version):
        raise ConfigError(f"{package.version!r} is not a package version; write three numbers, e.g. 0.1.0")
