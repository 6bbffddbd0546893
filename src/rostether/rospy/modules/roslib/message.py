"""roslib.message, as programs import it."""

# ruff: noqa: F401
from rostether.rospy.client.message import (
    DeserializationError,
    Message,
    SerializationError,
    strify_message,
)
from rostether.rospy.client.message_arguments import fill_message_args, get_printable_message_args
from rostether.rospy.client.message_types import get_message_class, get_service_class
from rostether.rospy.client.stamps import Duration, Time, TVal
