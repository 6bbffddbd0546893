"""rospkg: the folders and contents of packages."""

# ruff: noqa: F401
from importlib import import_module as _import_module

from rostether.rospy.tools.ros_packages import (
    Depend,
    InvalidManifest,
    Manifest,
    ResourceNotFound,
    RosPack,
    get_log_dir,
    get_package_name,
    get_ros_home,
    get_ros_package_path,
    get_ros_paths,
    get_ros_root,
    get_test_results_dir,
)

for _name in ("common", "environment", "rospack"):
    _import_module(f"rospkg.{_name}")
