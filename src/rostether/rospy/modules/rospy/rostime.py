"""rospy.rostime."""

# ruff: noqa: F401
from rostether.rospy.client.ros_time import Duration, Time, get_rostime, get_time, is_wallclock, wallsleep
