"""rospkg.common."""

# ruff: noqa: F401
from rostether.rospy_facade.ros_packages import ResourceNotFound
