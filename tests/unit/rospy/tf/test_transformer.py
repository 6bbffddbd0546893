"""The transformers of tf."""

from __future__ import annotations

from typing import Any

from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.ros_time import Time
from rostether.rospy.tf.geometry import transform_message
from rostether.rospy.tf.transformer import TransformerROS


def _message(kind: str, **fields: Any) -> Any:
    return all_types().message_class(kind)(**fields)


def test_point_cloud_in_another_frame() -> None:
    transformer = TransformerROS()
    stamp = Time(5)
    transformer.setTransform(transform_message("base", "laser", stamp, (1.0, 2.0, 3.0), (0.0, 0.0, 1.0, 0.0)))
    channel = _message("sensor_msgs/ChannelFloat32", name="intensity", values=[0.5])
    cloud = _message(
        "sensor_msgs/PointCloud", points=[_message("geometry_msgs/Point32", x=1.0)], channels=[channel]
    )
    cloud.header.stamp, cloud.header.frame_id = stamp, "/laser"
    moved = transformer.transformPointCloud("base", cloud)
    assert (moved.header.frame_id, moved.header.stamp) == ("base", stamp)
    assert moved.channels == [channel]
    assert [(point.x, point.y, point.z) for point in moved.points] == [(0.0, 2.0, 3.0)]
    assert type(moved) is type(cloud)
