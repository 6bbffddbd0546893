"""rospy.numpy_msg: message classes whose received arrays of numbers are numpy arrays."""

from __future__ import annotations

from functools import cache
from typing import Any

from rostether.rospy.client.message import Message


@cache
def numpy_msg(msg_type: type[Message]) -> type[Message]:
    """Return a subclass of a message class that reads arrays of numbers as numpy arrays.

    Raises ImportError if numpy is not installed.
    """
    # Imported by name, because only the program depends on numpy.
    from importlib import import_module

    numpy = import_module("numpy")

    def deserialize(self: Message, str: bytes) -> Message:
        return self.deserialize_numpy(str, numpy)

    def deserialize_numpy(self: Message, str: bytes, numpy: Any) -> Message:
        # Reads a message of the plain class, and copies its fields.
        found = msg_type().deserialize_numpy(str, numpy)
        for name in self._field_names():
            setattr(self, name, getattr(found, name))
        return self

    methods = {"__slots__": (), "deserialize": deserialize, "deserialize_numpy": deserialize_numpy}
    return type(f"Numpy_{msg_type._type.replace('/', '__')}", (msg_type,), methods)
