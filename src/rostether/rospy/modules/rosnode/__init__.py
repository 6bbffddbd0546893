"""rosnode: nodes."""

# ruff: noqa: F401
from rostether.rospy.tools.node_lookup import (
    ROSNodeException,
    ROSNodeIOException,
    cleanup_master_blacklist,
    get_api_uri,
    get_machines_by_nodes,
    get_node_info_description,
    get_node_names,
    get_nodes_by_machine,
    kill_nodes,
    rosnode_listnodes,
    rosnode_ping,
    rosnode_ping_all,
)
