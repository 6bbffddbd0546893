"""rosgraph: the master's API, and functions for names."""

from rostether.rospy.import_hook import import_submodules as _import_submodules
from rostether.rospy.tools.graph_names import myargv
from rostether.rospy.tools.master_tools import (
    Master,
    MasterError,
    MasterException,
    MasterFailure,
    get_master_uri,
    is_master_online,
)

from . import masterapi, rosenv
from .rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6, ROS_MASTER_URI, ROS_NAMESPACE

_import_submodules(__name__)
