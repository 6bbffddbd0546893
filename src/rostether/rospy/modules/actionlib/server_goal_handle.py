"""actionlib.server_goal_handle."""

# ruff: noqa: F401
from rostether.rospy.actionlib.server_goal import ServerGoalHandle
