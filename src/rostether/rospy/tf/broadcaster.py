"""The broadcaster of tf, the predecessor of tf2."""

from __future__ import annotations

from typing import Any

from rostether.rospy.tf import listener_and_broadcasters as tf2_ros
from rostether.rospy.tf.geometry import transform_message


class TransformBroadcaster:
    """Publishes transforms given as numbers."""

    def __init__(self, queue_size: int = tf2_ros.QUEUE_SIZE) -> None:
        self.tf2_broadcaster = tf2_ros.TransformBroadcaster()

    def sendTransform(self, translation: Any, rotation: Any, time: Any, child: str, parent: str) -> None:
        """Publish the pose of the frame `child` in `parent`."""
        self.sendTransformMessage(transform_message(parent, child, time, translation, rotation))

    def sendTransformMessage(self, transform: Any) -> None:
        """Publish a TransformStamped."""
        self.tf2_broadcaster.sendTransform([transform])
