"""Types with another name in ROS 2, and the changes of their fields."""

from __future__ import annotations

from types import MappingProxyType

from rostether.msgdef.ros2.from_ros1 import RENAMED_MESSAGES
from rostether.msgdef.ros2.to_ros1 import ros1_name
from rostether.serde.cdr.conversion_tree import Translation

# ROS 1's name to ROS 2's.
RENAMED_SERVICES = MappingProxyType({"roscpp/Empty": "std_srvs/srv/Empty"})

# (ROS 1 message, field) to ROS 2's field, unless only its case changed.
RENAMED_FIELDS = MappingProxyType({("rosgraph_msgs/Log", "header"): "stamp"})

_ROS2_LEVELS = ((16, 50), (8, 40), (4, 30), (2, 20), (1, 10), (0, 0))
_ROS1_LEVELS = ((50, 16), (40, 8), (30, 4), (20, 2), (0, 1))


def _levels(steps: tuple[tuple[int, int], ...]) -> bytes:
    return bytes(next(to for lowest, to in steps if value >= lowest) for value in range(256))


# (ROS 1 message, field of one byte) to its new values: a severity between two becomes the lower one.
RENAMED_VALUES = MappingProxyType(
    {("rosgraph_msgs/Log", "level"): Translation(_levels(_ROS2_LEVELS), _levels(_ROS1_LEVELS))}
)

# ROS 2's name to ROS 1's, if ROS 1 has no message with the name of ROS 2.
ROS1_MESSAGES = MappingProxyType(
    {
        "builtin_interfaces/msg/Duration": "std_msgs/Duration",
        "builtin_interfaces/msg/Time": "std_msgs/Time",
        "rcl_interfaces/msg/Log": "rosgraph_msgs/Log",
    }
)


def ros2_message_name(name: str) -> str:
    """Return ROS 2's name of a ROS 1 message."""
    package, _, short_name = name.partition("/")
    return RENAMED_MESSAGES.get(name) or f"{package}/msg/{short_name}"


def ros2_service_name(name: str) -> str:
    """Return ROS 2's name of a ROS 1 service."""
    package, _, short_name = name.partition("/")
    return RENAMED_SERVICES.get(name) or f"{package}/srv/{short_name}"


def ros1_message_name(ros2_name: str) -> str:
    """Return the ROS 1 name of a message `package/msg/Name` or `package/srv/Name_Request`."""
    return ROS1_MESSAGES.get(ros2_name) or ros1_name(ros2_name)


def ros1_service_name(ros2_name: str) -> str:
    """Return the ROS 1 name of a service `package/srv/Name`."""
    package, _, name = ros2_name.partition("/srv/")
    return f"{package}/{name}"
