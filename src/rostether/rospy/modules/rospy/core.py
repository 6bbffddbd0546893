"""rospy.core, as some programs import it."""

# ruff: noqa: F401
from rostether.rospy.client.exceptions import ROSException, ROSInitException
from rostether.rospy.client.logs import logdebug, logerr, logerror, logfatal, loginfo, logout, logwarn
from rostether.rospy.client.names import (
    get_caller_id,
    get_name,
    get_namespace,
    get_ros_root,
    remap_name,
    resolve_name,
)
from rostether.rospy.client.node import get_node_uri, is_initialized
from rostether.rospy.client.services import parse_rosrpc_uri
from rostether.rospy.client.shutdown import (
    add_preshutdown_hook,
    add_shutdown_hook,
    is_shutdown,
    is_shutdown_requested,
    signal_shutdown,
)
from rostether.rospy.client.shutdown import on_shutdown as add_client_shutdown_hook
