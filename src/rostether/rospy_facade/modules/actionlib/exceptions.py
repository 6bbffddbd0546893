"""actionlib.exceptions."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.action_types import ActionException
