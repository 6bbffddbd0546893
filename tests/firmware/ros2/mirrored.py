"""The messages that the sketch Mirror sends back: they fit into a board's buffer, and their numbers into its
4-byte double.
"""

from __future__ import annotations

from typing import Any

from firmware.ros2.serving import SKETCHES
from interop_ros2.samples import MESSAGES

MIRROR = SKETCHES / "Mirror"
NAMES = (
    "std_msgs/String",
    "sensor_msgs/Imu",
    "sensor_msgs/Range",
    "geometry_msgs/Twist",
    "sensor_msgs/JointState",
    "nav_msgs/Odometry",
    "sensor_msgs/CompressedImage",
)
MIRRORED: dict[str, dict[str, Any]] = {
    **{name: MESSAGES[name] for name in NAMES},
    "sensor_msgs/CompressedImage": {**MESSAGES["sensor_msgs/CompressedImage"], "data": list(range(256)) * 2},
}
