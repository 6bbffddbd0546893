"""actionlib.goal_id_generator."""

# ruff: noqa: F401
from rostether.rospy.actionlib.goal_ids import GoalIDGenerator
