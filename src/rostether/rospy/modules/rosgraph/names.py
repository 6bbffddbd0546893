"""rosgraph.names, as programs import it."""

# ruff: noqa: F401
from rostether.mechanisms.anonymous import anonymous_name
from rostether.names.graph_name import is_global, is_private
from rostether.rospy.tools.graph_names import (
    ANYTYPE,
    GLOBALNS,
    PRIV_NAME,
    REMAP,
    SEP,
    canonicalize_name,
    get_ros_namespace,
    is_legal_base_name,
    is_legal_name,
    is_legal_remap,
    isstring,
    load_mappings,
    make_caller_id,
    make_global_ns,
    namespace,
    ns_join,
    resolve_name,
    script_resolve_name,
)
