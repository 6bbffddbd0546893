"""rospy.names, as programs import it."""

# ruff: noqa: F401
from rostether.names.graph_name import is_global, is_private
from rostether.rospy.client.names import (
    get_caller_id,
    get_mappings,
    get_name,
    get_namespace,
    get_resolved_mappings,
    remap_name,
    resolve_name,
    resolve_name_without_node_name,
)
from rostether.rospy.tools.graph_names import (
    ANYTYPE,
    GLOBALNS,
    REMAP,
    SEP,
    canonicalize_name,
    get_ros_namespace,
    isstring,
    load_mappings,
    make_global_ns,
    namespace,
    ns_join,
    scoped_name,
)
from rostether.rospy.tools.graph_names import ANYTYPE as SERVICE_ANYTYPE
from rostether.rospy.tools.graph_names import ANYTYPE as TOPIC_ANYTYPE
