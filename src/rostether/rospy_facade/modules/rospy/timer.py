"""rospy.timer."""

# ruff: noqa: F401
from rostether.rospy_facade.ros_time import Rate, Timer, TimerEvent, sleep
