"""rospy.msg, as programs import it."""

# ruff: noqa: F401
from rostether.rospy.client.message import AnyMsg, serialize_message
from rostether.rospy.client.publisher import message_of as args_kwds_to_message
