"""Reads the words after `launch`: a launch file of a package, paths of files, `name:=value` arguments."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from msgspec import Struct, field

from rostether.errors import ConfigError
from rostether.mechanisms.text import did_you_mean
from rostether.names.remap import ASSIGNMENT
from rostether.packages.search_path import walk

STDIN = "-"
_ARGUMENT = re.compile(r"[~/A-Za-z_][\w/]*:=.*", re.DOTALL)
_LAUNCH_SUFFIXES = (".launch", ".xml", ".test")

# A longer list is unreadable in an error line.
_MAX_LISTED = 8

# Packages of rostether with the launch files of established packages, under the same names.
_BUNDLED = Path(__file__).with_name("share")


class LaunchSources(Struct, frozen=True):
    """The launch files, whether to read standard input too, and the arguments (the last one of each name).

    `empty_arguments` are the names of arguments with an empty value, which have no effect.
    """

    files: list[Path] = field(default_factory=list)
    reads_stdin: bool = False
    arguments: dict[str, str] = field(default_factory=dict)
    empty_arguments: list[str] = field(default_factory=list)


def _split_arguments(words: Sequence[str]) -> tuple[list[str], dict[str, str], list[str]]:
    """Return the other words, the arguments, and the names of arguments with an empty value."""
    rest: list[str] = []
    arguments: dict[str, str] = {}
    empty: list[str] = []
    for word in words:
        if not _ARGUMENT.fullmatch(word):
            rest.append(word)
            continue
        name, _, value = (part.strip() for part in word.partition(ASSIGNMENT))
        if not value:
            empty.append(name)
        elif not name.startswith("_") or name.startswith("__"):
            arguments[name] = value
    return rest, arguments, empty


def find_sources(words: Sequence[str], packages: Mapping[str, Path]) -> LaunchSources:
    """Find the launch files: `PACKAGE FILE`, or paths; `-` is standard input. Raises ConfigError."""
    rest, arguments, empty = _split_arguments(words)
    if not rest:
        raise ConfigError("give a launch file: `rostether launch PACKAGE FILE`, or a path")
    if len(rest) >= 2 and rest[0] in packages and rest[0] != STDIN:
        found = _in_package(rest[0], rest[1], packages[rest[0]])
        if found is not None:
            rest[:2] = [str(found)]
    missing = [each for each in rest if each != STDIN and not Path(each).is_file()]
    if missing:
        raise ConfigError(_explain_missing(rest, missing[0], packages))
    if rest.count(STDIN) > 1:
        raise ConfigError("standard input (-) can be read only once; give - once")
    files = [Path(each) for each in rest if each != STDIN]
    return LaunchSources(files, STDIN in rest, arguments, empty)


def _in_package(package: str, name: str, folder: Path) -> Path | None:
    """Return the file of a package with a name or path; None if there is none.

    Raises ConfigError if several files have the name.
    """
    if "/" in name:
        return folder / name if (folder / name).is_file() else None
    found = [each.path / name for each in walk(folder, below_packages=True) if name in each.files]
    if len(found) > 1:
        choices = ", ".join(str(each.relative_to(folder)) for each in found)
        raise ConfigError(f"package {package} has several files named {name}; give one of {choices}")
    return found[0] if found else None


def bundled_launch_packages() -> dict[str, Path]:
    """Map the names of bundled packages to their folders; user packages with the same name have priority."""
    return {folder.name: folder for folder in sorted(_BUNDLED.iterdir()) if folder.is_dir()}


def launch_files(folder: Path) -> list[str]:
    """Return the names of the launch files in a package, sorted."""
    return sorted(
        name
        for each in walk(folder, below_packages=True)
        for name in each.files
        if name.endswith(_LAUNCH_SUFFIXES) and name not in ("package.xml", "manifest.xml")
    )


def _explain_missing(words: list[str], missing: str, packages: Mapping[str, Path]) -> str:
    if len(words) < 2 or missing != words[0]:
        if Path(missing).is_dir():
            return f"{missing} is a folder; give a launch file in it"
        return f"there is no launch file {missing}; give its path, or PACKAGE FILE"
    package, name = words[0], words[1]
    if package not in packages:
        hint = did_you_mean(package, packages) or "`rostether pkg list` shows the packages found"
        return f"there is no package and no launch file {package}; {hint}"
    names = launch_files(packages[package])
    if hint := did_you_mean(name, names):
        return f"package {package} has no launch file {name}; {hint}"
    listed = ", ".join(names[:_MAX_LISTED]) + (", ..." if len(names) > _MAX_LISTED else "")
    return f"package {package} has no launch file {name}; it has {listed or 'none'}"
