"""The broadcaster of tf, the predecessor of tf2."""

from __future__ import annotations

from typing import Any

from rostether.rospy.client.message_types import all_types
from rostether.rospy.tf import listener_and_broadcasters as tf2_ros


class TransformBroadcaster:
    """Publishes transforms given as numbers."""

    def __init__(self, queue_size: int = tf2_ros.QUEUE_SIZE) -> None:
        self.tf2_broadcaster = tf2_ros.TransformBroadcaster()

    def sendTransform(self, translation: Any, rotation: Any, time: Any, child: str, parent: str) -> None:
        """Publish the pose of the frame `child` in `parent`."""
        message: Any = all_types().message_class("geometry_msgs/TransformStamped")()
        message.header.frame_id = parent
        message.header.stamp = time
        message.child_frame_id = child
        vector, quaternion = message.transform.translation, message.transform.rotation
        vector.x, vector.y, vector.z = translation
        quaternion.x, quaternion.y, quaternion.z, quaternion.w = rotation
        self.sendTransformMessage(message)

    def sendTransformMessage(self, transform: Any) -> None:
        """Publish a TransformStamped."""
        self.tf2_broadcaster.sendTransform([transform])
