"""The time for one message from ROS 1 serialization to CDR and back, compared with rosbags in the same run.

`compare()` returns the rows; python -m benchmarks cdr prints them.
"""

from __future__ import annotations

from typing import Any

from benchmarks.serde_codec import Row, best_ns
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.serde.cdr.converter import compile_message
from rostether.serde.cdr.renamed_types import ros2_message_name
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import TypeTrees

JOINTS = [f"joint_{number}" for number in range(6)]
TRANSFORMS = {"transforms": [{"header": {"frame_id": "odom"}, "child_frame_id": "base_link"}] * 4}
MESSAGES: dict[str, dict[str, Any]] = {
    "std_msgs/String": {"data": "a" * 60},
    "geometry_msgs/Twist": {},
    "sensor_msgs/Imu": {"header": {"frame_id": "imu_link"}, "orientation": {"w": 1.0}},
    "sensor_msgs/JointState": {"name": JOINTS, "position": [0.5] * 6, "velocity": [0.1] * 6},
    "nav_msgs/Odometry": {"header": {"frame_id": "odom"}, "child_frame_id": "base_link"},
    "sensor_msgs/LaserScan": {"header": {"frame_id": "laser"}, "ranges": [1.5] * 720},
    "tf2_msgs/TFMessage": TRANSFORMS,
    "sensor_msgs/CompressedImage": {"format": "jpeg", "data": bytes(50_000)},
}


def compare() -> list[Row]:
    """Measure both libraries in turns."""
    from rosbags.typesys import Stores, get_typestore

    store, definitions, rosbags = TypeStore(Registry()), Ros2Definitions(), get_typestore(Stores.ROS2_JAZZY)
    trees = TypeTrees(store.registry)
    rows: list[Row] = []
    for name, fields in MESSAGES.items():
        codec = store.codec(name)
        converter = compile_message(
            trees.struct(name), definitions.message(ros2_message_name(name)), definitions.message
        )
        payload = codec.encode(codec.conform(fields))
        rows += _compare_type(name, converter.to_cdr, converter.from_cdr, payload, rosbags)
    return rows


def _compare_type(name: str, to_cdr: Any, from_cdr: Any, payload: bytes, rosbags: Any) -> list[Row]:
    rosbags_name = name.replace("/", "/msg/")
    cdr = to_cdr(payload)
    assert from_cdr(cdr) == payload
    rosbags_ros1 = bytes(rosbags.cdr_to_ros1(cdr, rosbags_name))
    assert bytes(rosbags.ros1_to_cdr(rosbags_ros1, rosbags_name)) == cdr
    return [
        Row(
            f"{name} to CDR",
            best_ns(lambda: to_cdr(payload)),
            best_ns(lambda: rosbags.ros1_to_cdr(rosbags_ros1, rosbags_name)),
        ),
        Row(
            f"{name} from CDR",
            best_ns(lambda: from_cdr(cdr)),
            best_ns(lambda: rosbags.cdr_to_ros1(cdr, rosbags_name)),
        ),
    ]
