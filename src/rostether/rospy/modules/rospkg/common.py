"""rospkg.common."""

# ruff: noqa: F401
from rostether.rospy.tools.ros_packages import ResourceNotFound
