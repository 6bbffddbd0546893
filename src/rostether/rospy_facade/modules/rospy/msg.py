"""rospy.msg."""

# ruff: noqa: F401
from rostether.rospy_facade.message import AnyMsg
from rostether.rospy_facade.publisher import message_of as args_kwds_to_message
