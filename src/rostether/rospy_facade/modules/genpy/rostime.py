"""genpy.rostime."""

# ruff: noqa: F401
from rostether.rospy_facade.stamps import Duration, Time, TVal
