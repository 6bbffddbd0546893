"""actionlib.server_goal_handle."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.server_goal import ServerGoalHandle
