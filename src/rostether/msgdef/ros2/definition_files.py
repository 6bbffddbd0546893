"""Finds and reads definitions of ROS 2: of installed packages, in the user's folders, and the bundled ones.

An installed package PKG has them in `PREFIX/share/PKG/msg` and `.../srv`. The bundled ones are those of one
distribution, with a folder of differences for every other one.
"""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TypeAlias

from rostether.errors import ConfigError, DefinitionError
from rostether.msgdef.definition_files import MAX_LISTED_PACKAGES, Kind, read_definition
from rostether.msgdef.ros2.parse import parse_action, parse_message, parse_service
from rostether.msgdef.ros2.spec import Ros2Action, Ros2Message, Ros2Service
from rostether.packages.package_xml import PACKAGE_FILE, read_package_xml

Definition: TypeAlias = Ros2Message | Ros2Service | Ros2Action

BUNDLED_FOLDER = Path(__file__).with_name("share")
BUNDLED_DISTRO = "jazzy"
_ROS1_DISTROS = frozenset({"kinetic", "lunar", "melodic", "noetic"})
# Distribution -> folders that are searched before the bundled distribution's own; the first has priority.
_OVERLAYS: Mapping[str, tuple[str, ...]] = {
    "foxy": ("humble", "iron"),
    "galactic": ("humble", "iron"),
    "humble": ("humble", "iron"),
    "iron": ("iron",),
    "jazzy": (),
    "kilted": (),
    "lyrical": ("lyrical",),
    "rolling": ("lyrical",),
}
_ROS2_BUILD_TOOLS = frozenset(
    {"ament_cmake", "ament_cmake_auto", "ament_python", "rosidl_default_generators"}
)
_PREFIX_VARIABLES = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH")


def named_distro(environ: Mapping[str, str]) -> str:
    """Return the ROS 2 distribution of the variables; empty if none, as with the setup file of ROS 1."""
    name = environ.get("ROS_DISTRO", "").strip() if environ.get("ROS_VERSION", "2") == "2" else ""
    return "" if name in _ROS1_DISTROS else name


def install_prefixes(environ: Mapping[str, str]) -> list[Path]:
    """Return the folders of AMENT_PREFIX_PATH and COLCON_PREFIX_PATH, in order, each once."""
    parts = [part for name in _PREFIX_VARIABLES for part in environ.get(name, "").split(os.pathsep) if part]
    return [Path(part) for part in dict.fromkeys(parts)]


def python_prefixes() -> list[Path]:
    """Return the folders with definitions of packages from PyPI, if there are any."""
    prefix = Path(sys.prefix)
    return [prefix] if (prefix / "share" / "ament_index").is_dir() else []


class InstalledPackages:
    """The definitions below some install prefixes; each folder is read on first use."""

    def __init__(self, prefixes: Iterable[Path]) -> None:
        self.prefixes = list(prefixes)
        self._roots: dict[str, list[Path]] | None = None
        self._is_searched = False
        self._listings: dict[tuple[str, Kind], dict[str, Path]] = {}

    def packages(self) -> list[str]:
        """Return all packages that have definitions."""
        return [name for name in self._all_roots() if any(self.of(name, kind) for kind in Kind)]

    def of(self, package: str, kind: Kind) -> Mapping[str, Path]:
        """Return a package's files of one kind by type name; earlier prefixes have priority."""
        listing = self._listings.get((package, kind))
        if listing is None:
            # Stored when it is complete: a search in a thread may do the same.
            listing = {}
            for root in self._all_roots().get(package, ()):
                for name, file in _listing(root / kind, kind).items():
                    listing.setdefault(name, file)
            self._listings[package, kind] = listing
        return listing

    @property
    def is_searched(self) -> bool:
        """Whether all folders have been listed."""
        return self._is_searched or not self.prefixes

    def search(self) -> None:
        """List all folders now. It may take seconds."""
        self.packages()
        self._is_searched = True

    def has_only_idl(self, package: str, kind: Kind, name: str) -> bool:
        """Return whether the package was written in IDL, without .msg texts."""
        return any((root / kind / f"{name}.idl").is_file() for root in self._all_roots().get(package, ()))

    def _all_roots(self) -> dict[str, list[Path]]:
        if self._roots is None:
            roots: dict[str, list[Path]] = {}
            for prefix in self.prefixes:
                # colcon's own prefix has a prefix for each package, unless it installs them merged.
                for share in (prefix / "share", *sorted(prefix.glob("*/share"))):
                    for name in _subfolders(share):
                        roots.setdefault(name, []).append(share / name)
            self._roots = roots
        return self._roots


def declares_ros2(file: Path) -> bool | None:
    """Return whether the package.xml in or above a definition's folder is ROS 2's; None if it is unclear."""
    for folder in (file.parent, file.parent.parent):
        if not (folder / PACKAGE_FILE).is_file():
            continue
        try:
            package = read_package_xml(folder)
        except ConfigError:
            return None
        ros1 = "catkin" in package.dependencies or package.build_type == "catkin"
        ros2 = package.build_type.startswith("ament") or not _ROS2_BUILD_TOOLS.isdisjoint(
            package.dependencies
        )
        return None if ros1 == ros2 else ros2
    return None


def parse_file(kind: Kind, file: Path, package: str, name: str) -> Definition:
    """Return the definition in a file. Raises DefinitionError."""
    text = read_definition(file)
    if kind is Kind.ACTION:
        return parse_action(text, package=package, name=name, file=str(file))
    if kind is Kind.SERVICE:
        return parse_service(text, package=package, name=name, file=str(file))
    return parse_message(text, package=package, name=name, file=str(file))


def reads_as_ros2(kind: Kind, file: Path, package: str, *, has_header: bool) -> bool:
    """Return whether a text is valid in ROS 2; `has_header`: its package defines a `Header`."""
    try:
        found = parse_file(kind, file, package, file.stem)
    except DefinitionError:
        return False
    if has_header or package == "std_msgs":
        return True
    # A plain `Header` is std_msgs' in ROS 1 and the package's own in ROS 2.
    header = f"{package}/msg/Header"
    return not any(field.type.base == header for part in found.parts for field in part.fields)


@functools.lru_cache(maxsize=MAX_LISTED_PACKAGES)
def bundled_names(distro: str, package: str, kind: Kind) -> Mapping[str, Path]:
    """Return the bundled files of one kind for a package, by type name.

    For an unknown distribution, those of the newest one.
    """
    files: dict[str, Path] = {}
    for folder in (*_OVERLAYS.get(distro, _OVERLAYS["rolling"]), BUNDLED_DISTRO):
        if package in _bundled_packages_of(folder):
            for name, file in _listing(BUNDLED_FOLDER / folder / package / kind, kind).items():
                files.setdefault(name, file)
    return files


def bundled_packages() -> frozenset[str]:
    """Return the names of the packages with bundled definitions."""
    return _bundled_packages_of(BUNDLED_DISTRO)


@functools.cache
def _bundled_packages_of(folder: str) -> frozenset[str]:
    return frozenset(_subfolders(BUNDLED_FOLDER / folder))


def _listing(folder: Path, kind: Kind) -> dict[str, Path]:
    suffix = f".{kind}"
    try:
        names = sorted(entry.name for entry in folder.iterdir())
    except OSError:
        return {}
    return {name.removesuffix(suffix): folder / name for name in names if name.endswith(suffix)}


def _subfolders(folder: Path) -> list[str]:
    try:
        return sorted(entry.name for entry in folder.iterdir() if entry.is_dir())
    except OSError:
        return []
