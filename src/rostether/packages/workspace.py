"""A catkin workspace without catkin: its marks, what stands in it, and the setup files that shells source.

WORKSPACE/src/CMakeLists.txt     written by `init`
WORKSPACE/devel/setup.*          written by `make`: they put src on ROS_PACKAGE_PATH
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rostether.errors import ConfigError
from rostether.packages.executables import programs
from rostether.packages.locate import SOURCE_FOLDER
from rostether.packages.package_xml import MAX_PACKAGE_XML_BYTES, PackageXml, parse_package_xml
from rostether.packages.search_path import PACKAGE_FILE, find_packages, package_name, walk

WORKSPACE_MARK = ".catkin_workspace"
_DEVEL = "devel"
_OURS = "made by rostether, which needs no build"
_CMAKE = f"""\
# Top of a catkin workspace, {_OURS}; a real catkin finds its own.
cmake_minimum_required(VERSION 3.0.2)
project(Project)
find_package(catkin REQUIRED)
include(${{catkin_DIR}}/toplevel.cmake)
"""
_COMPILED_SOURCES = re.compile(r".*\.(cpp|cc|cxx|c)")


@dataclass(frozen=True, slots=True)
class PackageContents:
    """What one package has: nothing of it needs a build but `compiled_sources`."""

    description: PackageXml
    folder: Path
    messages: list[str]
    services: list[str]
    actions: list[str]
    nodes: list[str]
    launch_files: list[str]
    compiled_sources: list[str]


def init_workspace(source: Path) -> Path:
    """Mark a folder as the `src` of a workspace, and return the file that does. Raises ConfigError."""
    file = source / "CMakeLists.txt"
    if file.exists() or file.is_symlink():
        raise ConfigError(f"{file} is there already: this is a workspace, or a package")
    try:
        source.mkdir(parents=True, exist_ok=True)
        file.write_text(_CMAKE)
    except OSError as error:
        raise ConfigError(f"{error.filename}: {error.strerror}") from error
    return file


def read_workspace(workspace: Path) -> list[PackageContents]:
    """Look at every package of a workspace, sorted by name. Raises ConfigError when it has no `src`."""
    source = workspace / SOURCE_FOLDER
    if not source.is_dir():
        raise ConfigError(f"{workspace} has no folder src: a workspace keeps its packages there")
    return [read_contents(folder) for _, folder in sorted(find_packages([source]).items())]


def broken_packages(workspace: Path) -> list[str]:
    """Return a line for every package.xml of a workspace that cannot be read: its package is not seen."""
    lines = []
    for folder in walk(workspace / SOURCE_FOLDER):
        if folder.is_package and package_name(folder) is None:
            try:
                read_contents(folder.path)
            except (ConfigError, OSError) as error:
                lines.append(str(error))
    return lines


def read_contents(folder: Path) -> PackageContents:
    """Look at one package. Raises ConfigError when its package.xml is broken."""
    file = folder / PACKAGE_FILE
    name = folder.name
    if file.is_file():
        with file.open("rb") as stream:
            data = stream.read(MAX_PACKAGE_XML_BYTES + 1)
        description = parse_package_xml(data, file=str(file))
    else:
        description = PackageXml(name)
    found = sorted(each.path / name for each in walk(folder, below_packages=True) for name in each.files)
    return PackageContents(
        description=description,
        folder=folder,
        messages=[each.stem for each in found if each.suffix == ".msg" and each.parent.name == "msg"],
        services=[each.stem for each in found if each.suffix == ".srv" and each.parent.name == "srv"],
        actions=[each.stem for each in found if each.suffix == ".action" and each.parent.name == "action"],
        nodes=[each.name for each in programs(folder)],
        launch_files=[each.name for each in found if each.suffix == ".launch"],
        compiled_sources=[each.name for each in found if _COMPILED_SOURCES.fullmatch(each.name)],
    )


def write_setup_files(workspace: Path) -> list[Path]:
    """Write devel/setup.sh and its like; those of a real build are left alone. Raises ConfigError."""
    devel = workspace / _DEVEL
    written = []
    try:
        devel.mkdir(exist_ok=True)
        (workspace / WORKSPACE_MARK).touch()
        for name, text in _setup_texts(workspace / SOURCE_FOLDER).items():
            file = devel / name
            if not file.exists() or _OURS in file.read_text(errors="replace"):
                file.write_text(text)
                written.append(file)
    except OSError as error:
        raise ConfigError(f"{error.filename}: {error.strerror}") from error
    return written


def _setup_texts(source: Path) -> Mapping[str, str]:
    quoted = shlex.quote(str(source))
    posix = (
        f"# {_OURS}\n"
        f'case ":$ROS_PACKAGE_PATH:" in\n'
        f"    *:{quoted}:*) ;;\n"
        f'    *) ROS_PACKAGE_PATH={quoted}"${{ROS_PACKAGE_PATH:+:$ROS_PACKAGE_PATH}}" ;;\n'
        f"esac\nexport ROS_PACKAGE_PATH\n"
    )
    fish = (
        f"# {_OURS}\n"
        f"contains -- {quoted} (string split : -- $ROS_PACKAGE_PATH); or "
        f"set -gx ROS_PACKAGE_PATH (string join : -- {quoted} $ROS_PACKAGE_PATH)\n"
    )
    return {"setup.sh": posix, "setup.bash": posix, "setup.zsh": posix, "setup.fish": fish}
