"""rosgraph: the master's API, and functions for names."""

# ruff: noqa: F401
from importlib import import_module as _import_module

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

for _name in ("names", "network"):
    _import_module(f"rosgraph.{_name}")
