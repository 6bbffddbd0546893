"""tf2_ros.BufferInterface: transforms stamped messages with the lookups of a buffer."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar

from rostether.rospy.client.ros_time import Duration
from rostether.rospy.tf.exceptions import NotImplementedException, TypeException

NO_TIME = Duration(0)


class TransformRegistration:
    """How to transform stamped messages, by their class; shared by all buffers."""

    _by_class: ClassVar[dict[Any, Callable[[Any, Any], Any]]] = {}

    def add(self, key: Any, callback: Callable[[Any, Any], Any]) -> None:
        """Register a function that transforms messages of a class."""
        self._by_class[key] = callback

    def get(self, key: Any) -> Callable[[Any, Any], Any]:
        """Return the function for a class. Raises TypeException."""
        if key not in self._by_class:
            raise TypeException(f"Type {key} if not loaded or supported")
        return self._by_class[key]


class BufferInterface:
    """Transforms messages by looking up transforms."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(
        self, object_stamped: Any, target_frame: str, timeout: Any = NO_TIME, new_type: Any = None
    ) -> Any:
        """Return a stamped message in another frame. Import tf2_geometry_msgs for its types."""
        header = object_stamped.header
        found = self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        return _as_type(self.registration.get(type(object_stamped))(object_stamped, found), new_type)

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
        new_type: Any = None,
    ) -> Any:
        """Return a stamped message in another frame at another time."""
        header = object_stamped.header
        found = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        return _as_type(self.registration.get(type(object_stamped))(object_stamped, found), new_type)

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


def _as_type(message: Any, new_type: Any) -> Any:
    if new_type is None or isinstance(message, new_type):
        return message if new_type is None else deepcopy(message)
    raise TypeException(f"Type {new_type} if not loaded or supported")
