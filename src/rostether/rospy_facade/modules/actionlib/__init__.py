"""actionlib on rostether's graph."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.action_client import ActionClient
from rostether.rospy_facade.actions.action_server import ActionServer
from rostether.rospy_facade.actions.action_types import (
    ActionException,
    GoalID,
    GoalStatus,
    GoalStatusArray,
)
from rostether.rospy_facade.actions.action_types import name_of_state as get_name_of_constant
from rostether.rospy_facade.actions.client_goal import ClientGoalHandle
from rostether.rospy_facade.actions.comm_states import CommState, TerminalState
from rostether.rospy_facade.actions.goal_ids import GoalIDGenerator
from rostether.rospy_facade.actions.server_goal import ServerGoalHandle
from rostether.rospy_facade.actions.simple_action_client import SimpleActionClient, SimpleGoalState
from rostether.rospy_facade.actions.simple_action_server import SimpleActionServer

from . import (
    action_client,
    action_server,
    exceptions,
    goal_id_generator,
    server_goal_handle,
    simple_action_client,
    simple_action_server,
)
