"""Converts names of types between the spellings of ROS 1 and ROS 2."""

from __future__ import annotations


def short_type(name: str) -> str:
    """Return a type's name without the middle part of ROS 2: `std_msgs/msg/String` -> `std_msgs/String`."""
    parts = name.split("/")
    return f"{parts[0]}/{parts[2]}" if len(parts) == 3 else name


def long_type(name: str, kind: str) -> str:
    """Return a type's name with its middle part, msg or srv: `std_msgs/String` -> `std_msgs/msg/String`."""
    package, _, short_name = name.partition("/")
    return f"{package}/{kind}/{short_name}" if short_name and "/" not in short_name else name
