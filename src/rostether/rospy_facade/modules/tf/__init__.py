"""The first tf, on rostether's tf buffer."""

# ruff: noqa: F401, A004
from rostether.rospy_facade.tf_buffer import (
    ConnectivityException,
    ExtrapolationException,
    LookupException,
)
from rostether.rospy_facade.tf_buffer import TransformException as Exception
from rostether.rospy_facade.tf_transformer import (
    TransformBroadcaster,
    Transformer,
    TransformerROS,
    TransformListener,
)

from . import transformations
