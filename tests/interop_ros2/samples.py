"""Sample messages of ROS 2 with values in every kind of field."""

from __future__ import annotations

from typing import Any

from rostether.rostime import Time

HEADER = {"stamp": {"sec": 1700000000, "nanosec": 5}, "frame_id": "bäse_link"}
COVARIANCE9 = [number / 8 for number in range(9)]
COVARIANCE36 = [number / 4 for number in range(36)]
VECTOR = {"x": 1.5, "y": -2.0, "z": 0.25}
QUATERNION = {"x": 0.0, "y": 0.5, "z": -0.5, "w": 1.0}
TWIST = {"linear": VECTOR, "angular": {"x": 0.0, "y": 0.0, "z": 3.0}}

MESSAGES: dict[str, dict[str, Any]] = {
    "std_msgs/String": {"data": "hällo"},
    "std_msgs/Empty": {},
    "std_msgs/UInt8MultiArray": {
        "layout": {"dim": [{"label": "x", "size": 3, "stride": 3}], "data_offset": 1},
        "data": [1, 2, 255],
    },
    "geometry_msgs/Twist": TWIST,
    "sensor_msgs/Imu": {
        "header": HEADER,
        "orientation": QUATERNION,
        "orientation_covariance": COVARIANCE9,
        "angular_velocity": VECTOR,
        "angular_velocity_covariance": COVARIANCE9,
        "linear_acceleration": VECTOR,
        "linear_acceleration_covariance": COVARIANCE9,
    },
    "sensor_msgs/Range": {
        "header": HEADER,
        "radiation_type": 1,
        "field_of_view": 0.5,
        "min_range": 0.125,
        "max_range": 4.0,
        "range": 2.5,
    },
    "sensor_msgs/JointState": {
        "header": HEADER,
        "name": ["left", "right wheel", ""],
        "position": [0.5, -0.5, 0.0],
        "velocity": [],
        "effort": [1.0],
    },
    "nav_msgs/Odometry": {
        "header": HEADER,
        "child_frame_id": "wheels",
        "pose": {"pose": {"position": VECTOR, "orientation": QUATERNION}, "covariance": COVARIANCE36},
        "twist": {"twist": TWIST, "covariance": COVARIANCE36},
    },
    "sensor_msgs/CompressedImage": {
        "header": HEADER,
        "format": "jpeg",
        "data": list(range(256)) * 40,
    },
    "diagnostic_msgs/DiagnosticArray": {
        "header": HEADER,
        "status": [
            {
                "level": 2,
                "name": "motor",
                "message": "hot",
                "hardware_id": "m1",
                "values": [{"key": "temperature", "value": "90"}],
            }
        ],
    },
}

# Fields that ROS 1 does not have.
ADDED: dict[str, dict[str, Any]] = {
    "sensor_msgs/Range": {"variance": 0.0},
}


def ros2_name(name: str, kind: str = "msg") -> str:
    """Return `pkg/msg/Name` of `pkg/Name`."""
    package, short = name.split("/")
    return f"{package}/{kind}/{short}"


def with_times(values: Any) -> Any:
    """Return the same message with rostether's times, as a codec needs them."""
    if isinstance(values, dict):
        if values.keys() == {"sec", "nanosec"}:
            return Time(values["sec"], values["nanosec"])
        return {name: with_times(value) for name, value in values.items()}
    return [with_times(value) for value in values] if isinstance(values, list) else values


def without_seq(plain: Any) -> Any:
    """Return a ROS 1 message in the form of ROS 2: other names in times, headers without `seq`."""
    if isinstance(plain, dict):
        if plain.keys() == {"secs", "nsecs"}:
            return {"sec": plain["secs"], "nanosec": plain["nsecs"]}
        is_header = plain.keys() == {"seq", "stamp", "frame_id"}
        return {
            name: without_seq(value) for name, value in plain.items() if not (is_header and name == "seq")
        }
    return [without_seq(value) for value in plain] if isinstance(plain, list) else plain
