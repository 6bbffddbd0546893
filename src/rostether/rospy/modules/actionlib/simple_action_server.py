"""actionlib.simple_action_server."""

# ruff: noqa: F401
from rostether.rospy.actionlib.simple_action_server import SimpleActionServer
