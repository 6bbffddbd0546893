"""tf2_ros on rostether's tf buffer."""

# ruff: noqa: F401
from rostether.rospy_facade.tf_buffer import (
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
from rostether.rospy_facade.tf_endpoints import (
    StaticTransformBroadcaster,
    TransformBroadcaster,
    TransformListener,
)
