"""actionlib.action_client, as programs import it."""

# ruff: noqa: F401
from rostether.rospy.actionlib.action_client import ActionClient
from rostether.rospy.actionlib.client_goal import ClientGoalHandle
from rostether.rospy.actionlib.comm_states import CommState, TerminalState
