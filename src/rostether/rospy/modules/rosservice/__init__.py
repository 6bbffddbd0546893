"""rosservice: services, their types, and calling them by name."""

# ruff: noqa: F401
from rostether.rospy.client.message_types import get_service_class
from rostether.rospy.tools.service_lookup import (
    ROSServiceException,
    ROSServiceIOException,
    call_service,
    get_service_args,
    get_service_class_by_name,
    get_service_headers,
    get_service_list,
    get_service_node,
    get_service_type,
    get_service_uri,
    has_service_args,
    rosservice_find,
)
