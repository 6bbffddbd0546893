"""actionlib.action_server."""

# ruff: noqa: F401
from rostether.rospy_facade.actions.action_server import ActionServer
