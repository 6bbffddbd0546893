"""rospkg.rospack."""

# ruff: noqa: F401
from rostether.rospy_facade.ros_packages import RosPack, get_package_name
