"""roslib.packages."""

# ruff: noqa: F401
from rostether.rospy_facade.ros_packages import ResourceNotFound as InvalidROSPkgException
from rostether.rospy_facade.ros_packages import get_pkg_dir
