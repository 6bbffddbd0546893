"""actionlib.action_server."""

# ruff: noqa: F401
from rostether.rospy.actionlib.action_server import ActionServer
