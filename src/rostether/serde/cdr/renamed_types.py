"""Types with another name in ROS 2, and the changes of their fields."""

from __future__ import annotations

from types import MappingProxyType

from rostether.serde.cdr.conversion_tree import Translation

# ROS 1's name to ROS 2's. Types of the same name need no row, nor do fields that changed only their case.
RENAMED_MESSAGES = MappingProxyType(
    {
        "rosgraph_msgs/Log": "rcl_interfaces/msg/Log",
        "std_msgs/Duration": "builtin_interfaces/msg/Duration",
        "std_msgs/Time": "builtin_interfaces/msg/Time",
        "tf/tfMessage": "tf2_msgs/msg/TFMessage",
    }
)

RENAMED_SERVICES = MappingProxyType({"roscpp/Empty": "std_srvs/srv/Empty"})

# (ROS 1 message, field) to ROS 2's field.
RENAMED_FIELDS = MappingProxyType({("rosgraph_msgs/Log", "header"): "stamp"})

_ROS2_LEVELS = ((16, 50), (8, 40), (4, 30), (2, 20), (1, 10), (0, 0))
_ROS1_LEVELS = ((50, 16), (40, 8), (30, 4), (20, 2), (0, 1))


def _levels(steps: tuple[tuple[int, int], ...]) -> bytes:
    return bytes(next(to for least, to in steps if value >= least) for value in range(256))


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


def ros2_message_name(ros1_name: str) -> str:
    """Return ROS 2's name of a ROS 1 message."""
    package, _, name = ros1_name.partition("/")
    return RENAMED_MESSAGES.get(ros1_name) or f"{package}/msg/{name}"


def ros2_service_name(ros1_name: str) -> str:
    """Return ROS 2's name of a ROS 1 service."""
    package, _, name = ros1_name.partition("/")
    return RENAMED_SERVICES.get(ros1_name) or f"{package}/srv/{name}"


def ros1_message_name(ros2_name: str) -> str:
    """Return the ROS 1 name of a message `package/msg/Name` or `package/srv/Name_Request`."""
    if ros2_name in ROS1_MESSAGES:
        return ROS1_MESSAGES[ros2_name]
    package, kind, name = (*ros2_name.split("/"), "", "")[:3]
    return f"{package}/{name.replace('_', '') if kind == 'srv' else name}"


def ros1_service_name(ros2_name: str) -> str:
    """Return the ROS 1 name of a service `package/srv/Name`."""
    package, _, name = ros2_name.partition("/srv/")
    return f"{package}/{name}"
