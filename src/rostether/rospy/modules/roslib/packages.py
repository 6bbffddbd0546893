"""roslib.packages, as programs import it."""

# ruff: noqa: F401
from rostether.rospy.tools.ros_packages import ResourceNotFound as InvalidROSPkgException
from rostether.rospy.tools.ros_packages import find_node, find_resource, get_dir_pkg, get_pkg_dir
