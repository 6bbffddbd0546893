"""tf2_ros's and tf's listeners and broadcasters."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rostether.robot.tf_messages import TF_STATIC_TOPIC, TF_TOPIC, TF_TYPE
from rostether.rospy.client.logs import logwarn
from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.publisher import Publisher
from rostether.rospy.client.ros_time import get_rostime
from rostether.rospy.client.subscriber import DEFAULT_BUFF_SIZE, Subscriber
from rostether.rospy.tf.buffer import Buffer

# As in tf2_ros.
QUEUE_SIZE = 100
UNKNOWN_AUTHORITY = "default_authority"


class TransformListener:
    """Fills a buffer from /tf and /tf_static; a jump back in time clears it."""

    def __init__(
        self,
        buffer: Buffer,
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
        tcp_nodelay: bool = False,
    ) -> None:
        self.buffer = buffer
        self.last_update = get_rostime()
        self._lock = threading.Lock()
        tf_class = all_types().message_class(TF_TYPE)
        options: dict[str, Any] = {
            "queue_size": queue_size,
            "buff_size": buff_size,
            "tcp_nodelay": tcp_nodelay,
        }
        self.tf_sub = Subscriber(TF_TOPIC, tf_class, self.callback, **options)
        self.tf_static_sub = Subscriber(TF_STATIC_TOPIC, tf_class, self.static_callback, **options)

    def unregister(self) -> None:
        """Stop listening."""
        self.tf_sub.unregister()
        self.tf_static_sub.unregister()

    def callback(self, data: Any) -> None:
        """Store changing transforms."""
        self._store(data, self.buffer.set_transform)

    def static_callback(self, data: Any) -> None:
        """Store static transforms."""
        self._store(data, self.buffer.set_transform_static)

    def _store(self, data: Any, set_transform: Callable[[Any, str], None]) -> None:
        self._check_for_reset()
        authority = data._connection_header.get("callerid", UNKNOWN_AUTHORITY)
        for transform in data.transforms:
            set_transform(transform, authority)

    def _check_for_reset(self) -> None:
        with self._lock:
            now = get_rostime()
            if now < self.last_update:
                jump = (self.last_update - now).to_sec()
                logwarn("Detected jump back in time of %fs. Clearing TF buffer.", jump)
                self.buffer.clear()
            self.last_update = now


class _Broadcaster:
    """Publishes transforms on a topic."""

    def __init__(self, topic: str, *, latch: bool) -> None:
        tf_class = all_types().message_class(TF_TYPE)
        self.pub_tf = Publisher(topic, tf_class, queue_size=QUEUE_SIZE, latch=latch)

    def sendTransform(self, transform: Any) -> None:
        """Publish one TransformStamped or a list of them."""
        self.pub_tf.publish(transform if isinstance(transform, list) else [transform])


class TransformBroadcaster(_Broadcaster):
    """Publishes changing transforms."""

    def __init__(self) -> None:
        super().__init__(TF_TOPIC, latch=False)


class StaticTransformBroadcaster(_Broadcaster):
    """Publishes static transforms; later subscribers receive only those of the last call."""

    def __init__(self) -> None:
        super().__init__(TF_STATIC_TOPIC, latch=True)
