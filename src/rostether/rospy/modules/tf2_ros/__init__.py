"""tf2_ros on rostether's tf buffer."""

# ruff: noqa: F401
from rostether.rospy.tf.buffer import (
    Buffer,
    BufferInterface,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    NotImplementedException,
    TimeoutException,
    TransformException,
    TransformRegistration,
    TypeException,
)
from rostether.rospy.tf.endpoints import (
    StaticTransformBroadcaster,
    TransformBroadcaster,
    TransformListener,
)
