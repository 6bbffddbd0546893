"""rospy.timer."""

# ruff: noqa: F401
from rostether.rospy.client.ros_time import Rate, Timer, TimerEvent, sleep
