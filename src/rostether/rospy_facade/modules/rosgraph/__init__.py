"""rosgraph: the master's API."""

# ruff: noqa: F401
from rostether.rospy_facade.master_tools import (
    Master,
    MasterError,
    MasterException,
    MasterFailure,
    get_master_uri,
    is_master_online,
)
