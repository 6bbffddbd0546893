"""The environment for scripts with rostether's rospy; only `run` and `launch` set it, for their programs."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

# Package folders found by the program that starts a script, besides those of ROS_PACKAGE_PATH.
PACKAGES_VARIABLE = "ROSTETHER_PACKAGE_FOLDERS"

# The folders of rostether and of our rospy's dependencies, for scripts that name another Python.
IMPORT_VARIABLE = "ROSTETHER_IMPORT_PATH"

_NEEDED = ("rostether", "h11", "msgspec", "yaml")

# Goes on PYTHONPATH. It only holds a sitecustomize.py, which adds our rospy where there is no real one.
PATH_FOLDER = Path(__file__).with_name("path")


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
    changed[IMPORT_VARIABLE] = os.pathsep.join(_import_folders())
    if package_folders:
        changed[PACKAGES_VARIABLE] = os.pathsep.join(str(folder) for folder in package_folders.values())
    return changed


def _import_folders() -> list[str]:
    specs = [find_spec(name) for name in _NEEDED]
    origins = [spec.origin for spec in specs if spec is not None and spec.origin is not None]
    return list(dict.fromkeys(str(Path(origin).parents[1]) for origin in origins))
