"""The first tf, on rostether's tf buffer."""

# ruff: noqa: F401, A004
from rostether.rospy.tf.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    LookupException,
)
from rostether.rospy.tf.exceptions import TransformException as Exception
from rostether.rospy.tf.transformer import (
    TransformBroadcaster,
    Transformer,
    TransformerROS,
    TransformListener,
)

from . import transformations
