"""Finds the packages that a command can use: in ROS_PACKAGE_PATH, and around and below the current folder.

The first of two packages with the same name is used, as in a catkin overlay. The order is:

1. the folders of ROS_PACKAGE_PATH,
2. `src` of the catkin workspace around the current folder, and `./src`,
3. everything below the current folder,
4. the package around the current folder and those next to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from rostether.packages.package_xml import PACKAGE_FILE, is_package
from rostether.packages.search_path import OnDuplicate, find_packages, package_name, ros_package_path

SOURCE_FOLDER = "src"

# A folder with more entries is a download folder, not a collection of packages.
_MAX_NEIGHBORS = 1_000
_WORKSPACE_MARKS = (".catkin_workspace", ".catkin_tools", "devel/.catkin", "src/CMakeLists.txt")


def package_folders(
    environ: Mapping[str, str], cwd: Path, *, on_duplicate: OnDuplicate | None = None
) -> dict[str, Path]:
    """Map the names of all packages that a command in the folder `cwd` finds to their folders.

    Nothing needs to be built. Folders that cannot be read and broken packages are skipped.
    """
    found = find_packages(package_roots(environ, cwd), on_duplicate=on_duplicate)
    for folder in _around(cwd):
        if name := package_name(folder):
            found.setdefault(name, folder)
    return found


def installed_packages(prefixes: Iterable[Path]) -> dict[str, Path]:
    """Map the names of packages that ROS 2 has installed, in PREFIX/share/NAME, to their folders.

    `prefixes` are the folders of AMENT_PREFIX_PATH; the first one that has a package is used. Prefixes that
    cannot be read are skipped.
    """
    found: dict[str, Path] = {}
    for prefix in prefixes:
        try:
            folders = sorted((prefix / "share").iterdir())
        except OSError:
            continue
        for folder in folders:
            if folder.name not in found and (folder / PACKAGE_FILE).is_file():
                found[folder.name] = folder
    return found


def package_roots(environ: Mapping[str, str], cwd: Path) -> list[Path]:
    """Return the folders below which packages are searched, in order of priority."""
    roots = [cwd / each for each in ros_package_path(environ)]
    workspace = workspace_of(cwd)
    if workspace is not None:
        roots.append(workspace / SOURCE_FOLDER)
    roots += [cwd / SOURCE_FOLDER, cwd]
    return list(dict.fromkeys(root for root in roots if root.is_dir()))


def package_path(environ: Mapping[str, str]) -> list[Path]:
    """Return the folders of ROS_PACKAGE_PATH, and those of the workspace around the current folder."""
    try:
        cwd = Path.cwd()
        sources = (workspace_of(cwd) or cwd) / SOURCE_FOLDER
        return [*ros_package_path(environ), *([sources] if sources.is_dir() else []), *_around(cwd)]
    except OSError:
        # The current folder was deleted.
        return ros_package_path(environ)


def workspace_of(cwd: Path) -> Path | None:
    """Return the catkin workspace that a folder is in (or is): the nearest one that has a mark.

    Without a mark, it is the folder whose `src` contains `cwd` outside of any package, or None.
    """
    parents = _upward(cwd)
    for folder in parents:
        source = folder / SOURCE_FOLDER
        if (
            source.is_dir()
            and not is_package(folder)
            and any((folder / mark).exists() for mark in _WORKSPACE_MARKS)
        ):
            return folder
    package = package_around(cwd)
    for folder in parents if package is None else _upward(package.parent):
        if folder.name == SOURCE_FOLDER:
            return folder.parent
    return None


def package_around(cwd: Path) -> Path | None:
    """Return the root of the package that a folder is in (or is); None outside of packages."""
    return next((folder for folder in _upward(cwd) if is_package(folder)), None)


def _upward(cwd: Path) -> list[Path]:
    return [cwd, *cwd.parents]


def _around(cwd: Path) -> Iterator[Path]:
    """Yield the package around a folder, and the packages next to it."""
    package = package_around(cwd)
    if package is None:
        return
    yield package
    try:
        for _, neighbor in zip(range(_MAX_NEIGHBORS), sorted(package.parent.iterdir()), strict=False):
            if neighbor != package and is_package(neighbor):
                yield neighbor
    except OSError:
        return
