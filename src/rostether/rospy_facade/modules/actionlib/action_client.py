"""actionlib.action_client."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.action_client import ActionClient
from rostether.rospy_facade.actions.client_goal import ClientGoalHandle
from rostether.rospy_facade.actions.comm_states import CommState, TerminalState
