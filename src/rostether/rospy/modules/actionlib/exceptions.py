"""actionlib.exceptions."""

# ruff: noqa: F401
from rostether.rospy.actionlib.action_types import ActionException
