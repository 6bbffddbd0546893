"""actionlib.simple_action_server."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.simple_action_server import SimpleActionServer
