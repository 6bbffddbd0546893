"""The parts of rospkg and roslib.packages that nodes use: the folders, descriptions and files of packages."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from rostether.errors import ConfigError
from rostether.packages.locate import package_around
from rostether.packages.package_xml import (
    PACKAGE_FILE,
    ROSBUILD_FILE,
    PackageXml,
    read_package_xml,
)
from rostether.packages.search_path import find_packages, ros_package_path, walk
from rostether.rospy.import_hook import importable_packages


class ResourceNotFound(Exception):
    """The package was not found."""

    def __init__(self, msg: str, ros_paths: list[str] | None = None) -> None:
        super().__init__(msg)
        self.ros_paths = ros_paths


InvalidROSPkgException = ResourceNotFound


class InvalidManifest(Exception):
    """The package.xml cannot be read."""


class Depend:
    """A dependency on another package."""

    def __init__(self, name: str, type: str = "package") -> None:
        self.name = name
        self.type = type

    def __repr__(self) -> str:
        return self.name


class Manifest:
    """The contents of a package.xml."""

    def __init__(self, description: PackageXml, folder: Path) -> None:
        self.name = description.name
        self.version = description.version
        self.description = description.description
        self.licenses = list(description.licenses)
        self.license = ", ".join(description.licenses)
        self.author = ", ".join(f"Maintainer: {each}" for each in description.maintainers)
        self.depends = [Depend(name) for name in sorted(description.dependencies)]
        self.is_catkin = (folder / PACKAGE_FILE).is_file()
        self.filename = str(folder / (PACKAGE_FILE if self.is_catkin else ROSBUILD_FILE))
        self.type = "package"


class RosPack:
    """Finds packages below `ros_paths`; without them, the packages that this program can use."""

    @staticmethod
    def get_instance(ros_paths: list[str] | None = None) -> RosPack:
        """Return a new instance for these paths."""
        return RosPack(ros_paths)

    def __init__(self, ros_paths: list[str] | None = None) -> None:
        self._ros_paths = ros_paths

    @property
    def ros_paths(self) -> list[str]:
        """The folders that contain packages."""
        return get_ros_paths() if self._ros_paths is None else list(self._ros_paths)

    def get_ros_paths(self) -> list[str]:
        """Return the folders that contain packages."""
        return self.ros_paths

    def get_path(self, name: str) -> str:
        """Return a package's folder. Raises ResourceNotFound."""
        folder = self._folders().get(name)
        if folder is None:
            raise ResourceNotFound(name, self.ros_paths)
        return str(folder)

    def list(self) -> list[str]:
        """Return the names of all packages."""
        return sorted(self._folders())

    def get_manifest(self, name: str) -> Manifest:
        """Return the contents of a package.xml. Raises ResourceNotFound, InvalidManifest."""
        return _manifest_in(Path(self.get_path(name)))

    def get_depends(self, name: str, implicit: bool = True) -> Sequence[str]:
        """Return the dependencies of a package among the packages that are found.

        With `implicit`, indirect ones too. Raises ResourceNotFound, InvalidManifest.
        """
        here = self._folders()
        found: dict[str, None] = {}
        waiting = [name]
        while waiting:
            for each in self.get_manifest(waiting.pop()).depends:
                if each.name in here and each.name not in found:
                    found[each.name] = None
                    waiting += [each.name] if implicit else []
        return [*found]

    def get_depends_on(self, name: str, implicit: bool = True) -> Sequence[str]:
        """Return the packages that depend on a package, with `implicit` even indirectly."""
        found = []
        for each in self._folders():
            try:
                if name in self.get_depends(each, implicit):
                    found.append(each)
            except InvalidManifest:
                continue
        return found

    def _folders(self) -> dict[str, Path]:
        return (
            _all_folders()
            if self._ros_paths is None
            else find_packages(Path(each) for each in self._ros_paths)
        )


def get_package_name(path: str) -> str | None:
    """Return the package that contains a file or folder, or None."""
    folder, _ = get_dir_pkg(path)
    return None if folder is None else _manifest_in(Path(folder)).name


def get_dir_pkg(d: str) -> tuple[str | None, str | None]:
    """Return the folder of the package that contains a path, and its name, or (None, None)."""
    folder = package_around(Path(d).resolve())
    return (None, None) if folder is None else (str(folder), folder.name)


def get_pkg_dir(
    package: str, required: bool = True, ros_root: object = None, ros_package_path: object = None
) -> str | None:
    """Return a package's folder. Raises ResourceNotFound if it is `required`."""
    try:
        return RosPack().get_path(package)
    except ResourceNotFound:
        if required:
            raise
        return None


def find_resource(
    pkg: str,
    resource_name: str,
    filter_fn: Callable[[str], object] | None = None,
    rospack: RosPack | None = None,
) -> list[str]:
    """Return the files with this name in a package. Raises ResourceNotFound."""
    folder = Path((rospack or RosPack()).get_path(pkg))
    found = [
        str(each.path / resource_name)
        for each in walk(folder, below_packages=True)
        if resource_name in each.files
    ]
    return [each for each in found if filter_fn is None or filter_fn(each)]


def find_node(pkg: str, node_type: str, rospack: RosPack | None = None) -> list[str]:
    """Return the executable files with this name in a package. Raises ResourceNotFound."""
    return find_resource(pkg, node_type, lambda path: os.access(path, os.R_OK | os.X_OK), rospack)


def get_ros_paths(env: dict[str, str] | None = None) -> list[str]:
    """Return the folders of ROS_PACKAGE_PATH."""
    return [str(folder) for folder in ros_package_path(os.environ if env is None else env)]


def get_ros_package_path(env: dict[str, str] | None = None) -> str | None:
    """Return ROS_PACKAGE_PATH; None if it is not set."""
    return _variable("ROS_PACKAGE_PATH", env)


def get_ros_root(env: dict[str, str] | None = None) -> str | None:
    """Return ROS_ROOT; None if it is not set."""
    return _variable("ROS_ROOT", env)


def get_ros_home(env: dict[str, str] | None = None) -> str:
    """Return the folder for logs and other files of programs."""
    return _variable("ROS_HOME", env) or str(Path("~").expanduser() / ".ros")


def get_log_dir(env: dict[str, str] | None = None) -> str:
    """Return the folder for logs."""
    return _variable("ROS_LOG_DIR", env) or str(Path(get_ros_home(env)) / "log")


def get_test_results_dir(env: dict[str, str] | None = None) -> str:
    """Return the folder for test results."""
    return _variable("ROS_TEST_RESULTS_DIR", env) or str(Path(get_ros_home(env)) / "test_results")


def _variable(name: str, env: dict[str, str] | None) -> str | None:
    return (os.environ if env is None else env).get(name)


def _manifest_in(folder: Path) -> Manifest:
    try:
        return Manifest(read_package_xml(folder), folder)
    except ConfigError as error:
        raise InvalidManifest(f"{error}") from None


_all_folders = cache(importable_packages)
