"""genpy.rostime."""

# ruff: noqa: F401
from rostether.rospy.client.stamps import Duration, Time, TVal
