"""roslib.message."""

# ruff: noqa: F401
from rostether.rospy_facade.message import Message
from rostether.rospy_facade.message_types import get_message_class, get_service_class
