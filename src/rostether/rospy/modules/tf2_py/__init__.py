"""tf2_py: the buffer without subscriptions, and the exceptions."""

from rostether.rospy.tf.buffer import Buffer as BufferCore
from rostether.rospy.tf.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)
