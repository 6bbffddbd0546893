"""tf2_ros on rostether's tf buffer."""

from rostether.rospy.import_hook import import_submodules as _import_submodules
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

_import_submodules(__name__)
