"""The functions of rosservice for programs: they list services, look up their types, and call them."""

from __future__ import annotations

from typing import Any

from rostether.errors import ConfigError, RostetherError
from rostether.ros1.node.service_probe import probe_header
from rostether.rospy.client.exceptions import ROSException, ServiceException
from rostether.rospy.client.message import MessageException
from rostether.rospy.client.message_arguments import fill_message_args, get_printable_message_args
from rostether.rospy.client.message_types import all_types, get_service_class
from rostether.rospy.client.node import node
from rostether.rospy.client.ros_time import get_rostime
from rostether.rospy.client.services import ServiceProxy
from rostether.rospy.tools.graph_names import make_global_ns, script_resolve_name
from rostether.rospy.tools.master_tools import Master, MasterException, master_required

_OWN_NAME = "/rosservice"


class ROSServiceException(Exception):
    """The base of rosservice's errors."""


class ROSServiceIOException(ROSServiceException):
    """The master or a service does not answer."""


def get_service_list(
    node: str | None = None, namespace: str | None = None, include_nodes: bool = False
) -> list[Any]:
    """Return the services, or those of a node or namespace; with `include_nodes` as [service, nodes].

    Raises ROSServiceIOException.
    """
    with master_required(ROSServiceIOException):
        services = Master(_OWN_NAME).getSystemState()[2]
    if namespace:
        below = make_global_ns(namespace)
        services = [each for each in services if each[0] == namespace or each[0].startswith(below)]
    if node is not None:
        services = [each for each in services if node in each[1]]
    return services if include_nodes else [name for name, _ in services]


def get_service_uri(service_name: str) -> str | None:
    """Return the URI of a service; None if no node offers it. Raises ROSServiceIOException."""
    with master_required(ROSServiceIOException):
        try:
            return str(Master(_OWN_NAME).lookupService(service_name))
        except MasterException:
            return None


def get_service_node(service_name: str) -> str | None:
    """Return the node that offers a service; None if there is none. Raises ROSServiceIOException."""
    for name, nodes in get_service_list(include_nodes=True):
        if name == service_name and nodes:
            return str(nodes[0])
    return None


def get_service_headers(service_name: str, service_uri: str) -> dict[str, str]:
    """Return the connection header of a service's server.

    Raises ROSServiceException for an invalid URI, ROSServiceIOException if the server does not answer.
    """
    try:
        return node.loop.call(probe_header(service_name, service_uri, caller_id=_OWN_NAME))
    except ConfigError:
        raise ROSServiceException(
            f"service [{service_name}] has an invalid RPC URI [{service_uri}]"
        ) from None
    except RostetherError:
        raise ROSServiceIOException(
            f"Unable to communicate with service [{service_name}], address [{service_uri}]"
        ) from None


def get_service_type(service_name: str) -> str | None:
    """Return the type of a service; None if no node offers it. Raises ROSServiceIOException."""
    uri = get_service_uri(service_name)
    return None if uri is None else get_service_headers(service_name, uri).get("type")


def rosservice_find(service_type: str) -> list[str]:
    """Return the services of a type. Raises ROSServiceIOException if the master does not answer."""
    found = []
    for name in get_service_list():
        try:
            if get_service_type(name) == service_type:
                found.append(name)
        except ROSServiceIOException:
            continue
    return found


def get_service_class_by_name(service_name: str) -> Any:
    """Return the class of a service that is offered. Raises ROSServiceException."""
    kind = get_service_type(service_name)
    if not kind:
        known = service_name in get_service_list()
        raise ROSServiceException(
            f"Unable to determine type of service [{service_name}]."
            if known
            else f"Service [{service_name}] is not available."
        )
    # Old servers of roscpp send the type of the request.
    found = get_service_class(kind) or get_service_class(kind.removesuffix("Request"))
    if found is None:
        raise ROSServiceException(f"Unable to load type [{kind}].")
    return found


def call_service(service_name: str, service_args: list[Any], service_class: Any = None) -> tuple[Any, Any]:
    """Start a node and call a service with a list of arguments; return request and response.

    Raises ROSServiceException.
    """
    from rostether.rospy.client.client import init_node

    init_node("rosservice", anonymous=True)
    service_class = service_class or get_service_class_by_name(service_name)
    request = service_class._request_class()
    now = get_rostime()
    header: Any = all_types().message_class("std_msgs/Header")
    try:
        fill_message_args(request, service_args, keys={"now": now, "auto": header(stamp=now)})
        return request, ServiceProxy(service_name, service_class)(request)
    except MessageException as error:
        raise ROSServiceException(
            f"Incompatible arguments to call service:\n{error}\nProvided arguments are:\n{service_args}\n\n"
            f"Service arguments are: [{get_printable_message_args(request)}]"
        ) from None
    except (ServiceException, ROSException) as error:
        raise ROSServiceException(f"{error}") from None


def has_service_args(service_name: str, service_class: Any = None) -> bool:
    """Return whether a service's request has fields. Raises ROSServiceException."""
    name = script_resolve_name("rosservice", service_name)
    return bool((service_class or get_service_class_by_name(name))._request_class.__slots__)


def get_service_args(service_name: str) -> str:
    """Return the names of the fields of a service's request. Raises ROSServiceException."""
    found = get_service_class_by_name(script_resolve_name("rosservice", service_name))
    return get_printable_message_args(found._request_class())
