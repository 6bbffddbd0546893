"""rospy.names."""

# ruff: noqa: F401
from rostether.names.graph_name import is_global, is_private
from rostether.rospy_facade.names import (
    get_caller_id,
    get_mappings,
    get_name,
    get_namespace,
    get_resolved_mappings,
    remap_name,
    resolve_name,
)
