"""tf2_py: the exceptions of tf2."""

# ruff: noqa: F401
from rostether.rospy.tf.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)
