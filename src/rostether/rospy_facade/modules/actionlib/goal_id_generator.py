"""actionlib.goal_id_generator."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.goal_ids import GoalIDGenerator
