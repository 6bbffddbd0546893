"""rospkg and roslib.packages, as far as nodes use them: where a package's folder is."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from rostether.rospy_facade.import_hook import package_folders


class ResourceNotFound(Exception):  # noqa: N818 - the name is rospkg's
    """A package that is nowhere to be found."""

    def __init__(self, msg: str, ros_paths: list[str] | None = None) -> None:
        super().__init__(msg)
        self.ros_paths = ros_paths


class RosPack:
    """Finds packages in ROS_PACKAGE_PATH and where this program was started."""

    @staticmethod
    def get_instance(ros_paths: list[str] | None = None) -> RosPack:
        """Return one."""
        return RosPack(ros_paths)

    def __init__(self, ros_paths: list[str] | None = None) -> None:
        self._ros_paths = ros_paths

    def get_path(self, name: str) -> str:
        """Return a package's folder. Raises ResourceNotFound."""
        folder = self._folders().get(name)
        if folder is None:
            raise ResourceNotFound(name, self._ros_paths)
        return str(folder)

    def list(self) -> list[str]:
        """Return the names of all packages."""
        return sorted(self._folders())

    def _folders(self) -> dict[str, Path]:
        from rostether.packages.search_path import find_packages

        return (
            _all_folders()
            if self._ros_paths is None
            else find_packages(Path(each) for each in self._ros_paths)
        )


def get_pkg_dir(
    package: str, required: bool = True, ros_root: object = None, ros_package_path: object = None
) -> str:
    """Return a package's folder. Raises ResourceNotFound."""
    return RosPack().get_path(package)


@cache
def _all_folders() -> dict[str, Path]:
    return package_folders()
