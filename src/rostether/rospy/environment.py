"""The environment variables with which `run` and `launch` give scripts rostether's rospy."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from rostether.packages.search_path import ros_package_path

# The folders of the packages that `run` or `launch` has found, for the script that it starts.
PACKAGES_VARIABLE = "ROSTETHER_PACKAGE_FOLDERS"

# The folders of rostether and of our rospy's dependencies, for scripts that run on another Python.
IMPORT_VARIABLE = "ROSTETHER_IMPORT_PATH"

# The packages that our rospy imports.
_NEEDED = ("rostether", "h11", "msgspec", "yaml")

# The folder on PYTHONPATH. Its only file is sitecustomize.py, which adds our rospy if there is no real one.
PATH_FOLDER = Path(__file__).with_name("path")


def script_environment(
    environ: Mapping[str, str], package_folders: Mapping[str, Path] | None = None
) -> dict[str, str]:
    """Return `environ` with our rospy for Python scripts. Other programs can also run in it.

    `package_folders` are the packages that were found (`packages.locate.package_folders`). The script can
    import their messages, services and Python modules, in whatever folder it runs.
    """
    others = [part for part in environ.get("PYTHONPATH", "").split(os.pathsep) if part]
    own = str(PATH_FOLDER)
    changed = dict(environ)
    changed["PYTHONPATH"] = os.pathsep.join([own, *(part for part in others if part != own)])
    changed[IMPORT_VARIABLE] = os.pathsep.join(_import_folders())
    if package_folders:
        changed[PACKAGES_VARIABLE] = os.pathsep.join(str(folder) for folder in package_folders.values())
    return changed


def package_search_path(environ: Mapping[str, str]) -> list[Path]:
    """Return the folders of ROS_PACKAGE_PATH, and those of the packages that `run` or `launch` has found."""
    found = [Path(part) for part in environ.get(PACKAGES_VARIABLE, "").split(os.pathsep) if part]
    return [*ros_package_path(environ), *found]


def _import_folders() -> list[str]:
    specs = [find_spec(name) for name in _NEEDED]
    origins = [spec.origin for spec in specs if spec is not None and spec.origin is not None]
    return list(dict.fromkeys(str(Path(origin).parents[1]) for origin in origins))
