"""What the sketch Mirror gives back: messages that fit a board, with numbers that its 4-byte double holds."""

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
