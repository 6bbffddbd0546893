"""roslib.message."""

# ruff: noqa: F401
from rostether.rospy_facade.message import (
    DeserializationError,
    Message,
    SerializationError,
    strify_message,
)
from rostether.rospy_facade.message_arguments import fill_message_args, get_printable_message_args
from rostether.rospy_facade.message_types import get_message_class, get_service_class
from rostether.rospy_facade.stamps import Duration, Time, TVal
