"""actionlib.simple_action_client."""

# ruff: noqa: F401
from rostether.rospy.actionlib.simple_action_client import SimpleActionClient, SimpleGoalState
