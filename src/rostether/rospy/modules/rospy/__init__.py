"""rospy on rostether's graph, for scripts of `run` and `launch` on a machine without a real rospy."""

from importlib import import_module as _import_module

from rostether.rospy.client.client import init_node, myargv, spin, wait_for_message
from rostether.rospy.client.exceptions import (
    ROSException,
    ROSInitException,
    ROSInternalException,
    ROSInterruptException,
    ROSSerializationException,
    ROSTimeMovedBackwardsException,
    ServiceException,
    TransportException,
    TransportInitError,
    TransportTerminated,
)
from rostether.rospy.client.logs import (
    DEBUG,
    ERROR,
    FATAL,
    INFO,
    WARN,
    logdebug,
    logdebug_once,
    logdebug_throttle,
    logdebug_throttle_identical,
    logerr,
    logerr_once,
    logerr_throttle,
    logerr_throttle_identical,
    logerror,
    logfatal,
    logfatal_once,
    logfatal_throttle,
    logfatal_throttle_identical,
    loginfo,
    loginfo_once,
    loginfo_throttle,
    loginfo_throttle_identical,
    logout,
    logwarn,
    logwarn_once,
    logwarn_throttle,
    logwarn_throttle_identical,
)
from rostether.rospy.client.message import AnyMsg, Message
from rostether.rospy.client.names import (
    get_caller_id,
    get_name,
    get_namespace,
    get_ros_root,
    remap_name,
    resolve_name,
)
from rostether.rospy.client.node import get_node_uri
from rostether.rospy.client.parameters import (
    MasterProxy,
    delete_param,
    get_master,
    get_param,
    get_param_cached,
    get_param_names,
    get_published_topics,
    has_param,
    search_param,
    set_param,
)
from rostether.rospy.client.publisher import Publisher, SubscribeListener
from rostether.rospy.client.ros_time import Duration, Rate, Time, Timer, get_rostime, get_time, sleep
from rostether.rospy.client.services import Service, ServiceProxy, parse_rosrpc_uri, wait_for_service
from rostether.rospy.client.shutdown import is_shutdown, on_shutdown, signal_shutdown
from rostether.rospy.client.subscriber import Subscriber
from rostether.rospy.import_hook import import_submodules as _import_submodules

_import_submodules(__name__)

# Programs write `import std_msgs` alone, because the real rospy has imported these already.
for _module in ("std_msgs.msg", "rosgraph_msgs.msg", "roscpp.msg", "roscpp.srv"):
    _import_module(_module)
Header = _import_module("std_msgs.msg").Header
