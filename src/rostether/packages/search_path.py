"""Finds ROS packages on disk: breadth first, bounded, never below a package, like rospack and catkin."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.packages.package_xml import PACKAGE_FILE, ROSBUILD_FILE, read_package_xml

# A large workspace has a few thousand folders; a home directory must not be searched completely.
MAX_FOLDERS = 20_000

# workspace/src/repository/stack/package has depth 4; deeper than 12 is not a workspace.
MAX_DEPTH = 12

# All programs of the system have folders here; ROS packages are only at the top level, as in Debian's rospkg.
SYSTEM_SHARE_FOLDERS = frozenset({"/usr/share", "/usr/local/share"})
_IGNORE_FILE = "CATKIN_IGNORE"

# Folders of compiled modules, which are half of the folders of a Python package.
_BYTE_CODE_FOLDER = "__pycache__"

# A file in catkin's `devel` and `install`, and how deep copies of packages are below them, in share/NAME.
_CATKIN_MARK = ".catkin"
_COPY_DEPTH = 3
_NO_SUBFOLDERS_FILE = "rospack_nosubdirs"


class Folder(Struct, frozen=True):
    """A folder with the names of its files."""

    path: Path
    files: frozenset[str]

    @property
    def is_package(self) -> bool:
        """Whether the folder is a package's root."""
        return PACKAGE_FILE in self.files or ROSBUILD_FILE in self.files


def ros_package_path(environ: Mapping[str, str]) -> list[Path]:
    """Return the folders of ROS_PACKAGE_PATH in order; empty when it is not set."""
    return [Path(part) for part in environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]


# Called for two packages with one name below one root: gets the name, the folder in use, and the other one.
OnDuplicate = Callable[[str, Path, Path], object]


def find_packages(roots: Iterable[Path], *, on_duplicate: OnDuplicate | None = None) -> dict[str, Path]:
    """Map the names of all packages below the roots to their folders; the first package of a name is used.

    Folders that cannot be read and packages with a broken package.xml are skipped, so that one bad checkout
    does not hide the others.
    """
    found: dict[str, Path] = {}
    reported: set[Path] = set()
    for root in roots:
        # One root may overlay another: a second package with the same name is a mistake only below one root.
        below: dict[str, Path] = {}
        for folder in walk(root):
            if not folder.is_package or not (name := package_name(folder.path)):
                continue
            used = found.setdefault(name, folder.path)
            first = below.setdefault(name, folder.path)
            other = folder.path if used != folder.path else first
            if on_duplicate and other not in (used, *reported) and first != folder.path and _is_source(other):
                reported.add(other)
                on_duplicate(name, used, other)
    return found


def _is_source(package: Path) -> bool:
    """Return whether a package folder is the source, not catkin's copy."""
    return not any((folder / _CATKIN_MARK).exists() for folder in [*package.parents][:_COPY_DEPTH])


def package_name(root: Path) -> str | None:
    """Return the name of a package, given its root; None if its description is broken or missing."""
    try:
        return read_package_xml(root).name
    except ConfigError:
        return None


def walk(root: Path, *, below_packages: bool = False) -> Iterator[Folder]:
    """Yield the root and the folders below it, nearest first.

    Skips hidden folders, `__pycache__`, folders with a CATKIN_IGNORE file and, without `below_packages`, the
    folders inside a package. Follows links, but visits no folder twice. Stops at MAX_DEPTH, and after
    MAX_FOLDERS folders.
    """
    seen: set[tuple[int, int]] = set()
    start = os.path.abspath(root)  # noqa: PTH100 - Path has no way to do this without following links
    max_depth = 1 if start in SYSTEM_SHARE_FOLDERS else MAX_DEPTH
    waiting: deque[tuple[str, int]] = deque([(start, 0)])
    visited = 0
    while waiting and visited < MAX_FOLDERS:
        path, depth = waiting.popleft()
        visited += 1
        listing = _list_folder(path, seen)
        if listing is None:
            continue
        files, subfolders = listing
        folder = Folder(Path(path), files)
        yield folder
        stops = _NO_SUBFOLDERS_FILE in files or (folder.is_package and not below_packages)
        if not stops and depth < max_depth:
            waiting.extend((subfolder, depth + 1) for subfolder in subfolders)


def _list_folder(path: str, seen: set[tuple[int, int]]) -> tuple[frozenset[str], list[str]] | None:
    files: set[str] = set()
    subfolders: list[str] = []
    try:
        status = os.stat(path)  # noqa: PTH116 - this is the hot loop of a search
        identity = (status.st_dev, status.st_ino)
        # Windows file systems without file ids give 0 for all.
        if identity in seen and status.st_ino:
            return None
        seen.add(identity)
        with os.scandir(path) as entries:
            for entry in entries:
                if entry.name.startswith(".") or entry.name == _BYTE_CODE_FOLDER:
                    continue
                if entry.is_dir():
                    subfolders.append(entry.path)
                else:
                    files.add(entry.name)
    except OSError:
        return None
    if _IGNORE_FILE in files:
        return None
    return frozenset(files), sorted(subfolders)
