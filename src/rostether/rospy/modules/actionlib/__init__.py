"""actionlib on rostether's graph."""

from rostether.rospy.actionlib.action_client import ActionClient
from rostether.rospy.actionlib.action_server import ActionServer
from rostether.rospy.actionlib.action_types import ActionException, GoalID, GoalStatus, GoalStatusArray
from rostether.rospy.actionlib.action_types import name_of_state as get_name_of_constant
from rostether.rospy.actionlib.client_goal import ClientGoalHandle
from rostether.rospy.actionlib.comm_states import CommState, TerminalState
from rostether.rospy.actionlib.goal_ids import GoalIDGenerator
from rostether.rospy.actionlib.server_goal import ServerGoalHandle
from rostether.rospy.actionlib.simple_action_client import SimpleActionClient, SimpleGoalState
from rostether.rospy.actionlib.simple_action_server import SimpleActionServer
from rostether.rospy.import_hook import import_submodules as _import_submodules

_import_submodules(__name__)
