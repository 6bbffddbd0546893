"""genpy, as far as programs use it: message values, their base class and their errors."""

# ruff: noqa: F401
from rostether.rospy_facade.message import (
    DeserializationError,
    Message,
    MessageException,
    SerializationError,
    strify_message,
)
from rostether.rospy_facade.stamps import Duration, Time, TVal

from . import message, rostime
