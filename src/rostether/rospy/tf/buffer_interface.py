"""tf2_ros.BufferInterface: transforms stamped messages with the lookups of a buffer."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar, TypeVar

from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.ros_time import Duration
from rostether.rospy.tf.exceptions import NotImplementedException, TypeException

NO_TIME = Duration(0)

_Function = TypeVar("_Function", bound=Callable[..., Any])


class TransformRegistration:
    """The functions that transform stamped messages, by their class; all buffers share them."""

    _by_class: ClassVar[dict[Any, Callable[[Any, Any], Any]]] = {}

    def add(self, key: Any, callback: Callable[[Any, Any], Any]) -> None:
        """Register the function that transforms messages of a class."""
        self._by_class[key] = callback

    def get(self, key: Any) -> Callable[[Any, Any], Any]:
        """Return the function that transforms messages of a class. Raises TypeException."""
        return _registered(self._by_class, key)


class ConvertRegistration:
    """The functions that convert between classes, directly or by a message; all buffers share them."""

    _to_message: ClassVar[dict[Any, Callable[[Any], Any]]] = {}
    _from_message: ClassVar[dict[Any, Callable[[Any], Any]]] = {}
    _directly: ClassVar[dict[Any, Callable[[Any], Any]]] = {}

    def add_to_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register the function that converts values of a class to messages."""
        self._to_message[key] = callback

    def add_from_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register the function that converts messages to values of a class."""
        self._from_message[key] = callback

    def add_convert(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register the function that converts values of `key[0]` to `key[1]`, a pair of classes."""
        self._directly[key] = callback

    def get_to_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return the function that converts values of a class to messages. Raises TypeException."""
        return _registered(self._to_message, key)

    def get_from_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return the function that converts messages to values of a class. Raises TypeException."""
        return _registered(self._from_message, key)

    def get_convert(self, key: Any) -> Callable[[Any], Any]:
        """Return the function that converts between a pair of classes. Raises TypeException."""
        return _registered(self._directly, key)


def _registered(functions: dict[Any, _Function], key: Any) -> _Function:
    if key not in functions:
        raise TypeException(f"Type {key} if not loaded or supported")
    return functions[key]


def convert(a: Any, b_type: Any) -> Any:
    """Return a value converted to a class, or a copy if it has the class. Raises TypeException."""
    registration = ConvertRegistration()
    try:
        function = registration.get_convert((type(a), b_type))
    except TypeException:
        if type(a) is b_type:
            return deepcopy(a)
        return registration.get_from_msg(b_type)(registration.get_to_msg(type(a))(a))
    return function(a)


def Stamped(obj: Any, stamp: Any, frame_id: str) -> Any:
    """Return the object with a new header."""
    obj.header = all_types().message_class("std_msgs/Header")(stamp=stamp, frame_id=frame_id)
    return obj


class BufferInterface:
    """The base of buffers: transforms messages with the lookups of a subclass."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(
        self, object_stamped: Any, target_frame: str, timeout: Any = NO_TIME, new_type: Any = None
    ) -> Any:
        """Return a stamped message in another frame; its type needs an import such as tf2_geometry_msgs.

        Raises TypeException, and the errors of `lookup_transform`.
        """
        header = object_stamped.header
        found = self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        moved = self.registration.get(type(object_stamped))(object_stamped, found)
        return convert(moved, new_type) if new_type else moved

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
        new_type: Any = None,
    ) -> Any:
        """Return a stamped message in another frame at another time.

        Raises TypeException, and the errors of `lookup_transform_full`.
        """
        header = object_stamped.header
        found = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        moved = self.registration.get(type(object_stamped))(object_stamped, found)
        return convert(moved, new_type) if new_type else moved

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = NO_TIME
    ) -> Any:
        """Return the pose of the source in the target."""
        raise NotImplementedException

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
    ) -> Any:
        """Return the pose of the source at one time in the target at another."""
        raise NotImplementedException
