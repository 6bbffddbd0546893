"""rosgraph.network."""

# ruff: noqa: F401
from rostether.rospy.tools.graph_network import (
    get_address_override,
    get_host_name,
    get_local_address,
    parse_http_host_and_port,
)
