"""rospkg: where packages are."""

# ruff: noqa: F401
from rostether.rospy_facade.ros_packages import ResourceNotFound, RosPack

from . import common as common
