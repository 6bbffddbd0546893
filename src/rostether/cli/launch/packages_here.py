"""The packages that a command finds, with warnings about duplicate names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rostether.cli.shell.output import warn
from rostether.packages.locate import package_folders
from rostether.packages.search_path import OnNamesake

# Warnings about packages with the same name; more appear only if a whole workspace was copied.
MAX_TOLD = 3


def packages_here() -> dict[str, Path]:
    """Return the folders of all packages that this command finds; warns about duplicate names."""
    with warned_namesakes() as on_namesake:
        return package_folders(os.environ, Path.cwd(), on_namesake=on_namesake)


@contextmanager
def warned_namesakes() -> Iterator[OnNamesake]:
    """Yield a callback for packages with the same name, and print a warning for each at the end."""
    lines: list[str] = []

    def note(name: str, used: Path, other: Path) -> None:
        lines.append(
            f"rostether: warning: two packages have the name {name}: using {used}, ignoring {other}; rename "
            f"one, or create a file CATKIN_IGNORE in its folder"
        )

    yield note
    for line in lines[:MAX_TOLD]:
        warn(line)
    if len(lines) > MAX_TOLD:
        warn(f"rostether: warning: {len(lines) - MAX_TOLD} more packages have duplicate names")
