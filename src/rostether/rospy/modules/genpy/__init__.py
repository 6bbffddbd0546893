"""genpy, as far as programs use it: message values, their base class and their errors."""

# ruff: noqa: F401
import struct as _struct
from importlib import import_module as _import_module

from rostether.rospy.client.message import (
    DeserializationError,
    Message,
    MessageException,
    SerializationError,
    strify_message,
)
from rostether.rospy.client.stamps import Duration, Time, TVal

for _name in ("dynamic", "message", "rostime"):
    _import_module(f"genpy.{_name}")

struct_I = _struct.Struct("<I")  # noqa: N816
