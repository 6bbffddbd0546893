"""tf, the predecessor of tf2, on rostether's tf buffer."""

# ruff: noqa: F401, A004
from importlib import import_module as _import_module

from rostether.rospy.tf.broadcaster import TransformBroadcaster
from rostether.rospy.tf.exceptions import ConnectivityException, ExtrapolationException, LookupException
from rostether.rospy.tf.exceptions import TransformException as Exception
from rostether.rospy.tf.transformer import Transformer, TransformerROS, TransformListener

for _name in ("broadcaster", "listener", "transformations"):
    _import_module(f"tf.{_name}")
