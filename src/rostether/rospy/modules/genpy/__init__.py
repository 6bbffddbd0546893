"""genpy, as far as programs use it: message values, their base class and their errors."""

import struct as _struct

from rostether.rospy.client.message import (
    DeserializationError,
    Message,
    MessageException,
    SerializationError,
    strify_message,
)
from rostether.rospy.client.stamps import Duration, Time, TVal
from rostether.rospy.import_hook import import_submodules as _import_submodules

_import_submodules(__name__)

struct_I = _struct.Struct("<I")
