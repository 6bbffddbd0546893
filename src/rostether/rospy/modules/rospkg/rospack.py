"""rospkg.rospack."""

# ruff: noqa: F401
from rostether.rospy.tools.ros_packages import RosPack, get_package_name
