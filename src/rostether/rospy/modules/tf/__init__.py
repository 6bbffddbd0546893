"""tf, the predecessor of tf2, on rostether's tf buffer."""

from rostether.rospy.import_hook import import_submodules as _import_submodules
from rostether.rospy.tf.broadcaster import TransformBroadcaster
from rostether.rospy.tf.exceptions import ConnectivityException, ExtrapolationException, LookupException
from rostether.rospy.tf.exceptions import TransformException as Exception
from rostether.rospy.tf.transformer import Transformer, TransformerROS, TransformListener

_import_submodules(__name__)
