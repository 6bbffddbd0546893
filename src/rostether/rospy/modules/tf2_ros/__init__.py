"""tf2_ros on rostether's tf buffer."""

# ruff: noqa: F401
from importlib import import_module as _import_module

from rostether.rospy.tf.buffer import Buffer
from rostether.rospy.tf.buffer import Buffer as BufferCore
from rostether.rospy.tf.buffer_client import BufferClient
from rostether.rospy.tf.buffer_interface import (
    BufferInterface,
    ConvertRegistration,
    Stamped,
    TransformRegistration,
    convert,
)
from rostether.rospy.tf.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    NotImplementedException,
    TimeoutException,
    TransformException,
    TypeException,
)
from rostether.rospy.tf.listener_and_broadcasters import (
    StaticTransformBroadcaster,
    TransformBroadcaster,
    TransformListener,
)

for _name in (
    "buffer",
    "buffer_client",
    "buffer_interface",
    "static_transform_broadcaster",
    "transform_broadcaster",
    "transform_listener",
):
    _import_module(f"tf2_ros.{_name}")
