"""The environment in which a script finds our rospy; only `run` and `launch` give it, to what they start."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

PACKAGES_VARIABLE = "ROSTETHER_PACKAGE_FOLDERS"
"""Folders of packages that whoever starts a script has found, besides those of ROS_PACKAGE_PATH."""

PATH_FOLDER = Path(__file__).with_name("path")
"""Goes on PYTHONPATH. It only holds a sitecustomize.py, which adds our rospy where there is no real one."""


def node_environment(
    environ: Mapping[str, str], package_folders: Mapping[str, Path] | None = None
) -> dict[str, str]:
    """Return `environ` with our rospy for Python scripts; harmless for every other program.

    `package_folders` are the packages found (`packages.locate.package_folders`): their messages, services and
    Python modules are importable in the script, wherever it is started.
    """
    others = [part for part in environ.get("PYTHONPATH", "").split(os.pathsep) if part]
    own = str(PATH_FOLDER)
    changed = dict(environ)
    changed["PYTHONPATH"] = os.pathsep.join([own, *(part for part in others if part != own)])
    if package_folders:
        changed[PACKAGES_VARIABLE] = os.pathsep.join(str(folder) for folder in package_folders.values())
    return changed
