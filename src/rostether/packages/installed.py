"""Packages as ROS 2 installs them: `share/NAME` below each prefix in AMENT_PREFIX_PATH."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rostether.packages.package_xml import PACKAGE_FILE

_SHARE = "share"


def installed_packages(prefixes: Iterable[Path]) -> dict[str, Path]:
    """Map the names of all installed packages to their folders; the first prefix that has one is used.

    Prefixes that cannot be read are skipped.
    """
    found: dict[str, Path] = {}
    for prefix in prefixes:
        try:
            folders = sorted((prefix / _SHARE).iterdir())
        except OSError:
            continue
        for folder in folders:
            if folder.name not in found and (folder / PACKAGE_FILE).is_file():
                found[folder.name] = folder
    return found
