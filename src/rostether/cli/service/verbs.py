"""`rostether service`: lists, shows and calls services of a ROS 1 or ROS 2 graph."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import click

from rostether.cli.access.completions import complete_service_types, complete_services
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option, refuse_ros2
from rostether.cli.service.options import CallOptions, ServiceListing
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import verb

_service_argument = click.argument("service", shell_complete=complete_services)


class Services(Protocol):
    """The services of one graph. Each method is a whole command; it raises RostetherError or UsageError."""

    async def list_services(self, wanted: ServiceListing) -> None:
        """Print the services."""

    async def type_of(self, service: str) -> None:
        """Print the type of a service."""

    async def node_of(self, service: str) -> None:
        """Print the node that offers a service."""

    async def args(self, service: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the names of a service's arguments."""

    async def info(self, service: str, msg_paths: tuple[Path, ...], *, as_json: bool) -> None:
        """Print a service's type and servers; in ROS 1 also its arguments, in ROS 2 its clients."""

    async def find(self, type_name: str) -> None:
        """Print the services of a type."""

    async def call(self, service: str, values: tuple[str, ...], options: CallOptions) -> None:
        """Call a service and print its response."""


def services_of(graph: GraphOptions) -> Services:
    """Return the services of the graph that the command line selects."""
    if graph.ros2 is None:
        from rostether.cli.service.ros1_services import Ros1Services

        return Ros1Services(graph)
    from rostether.cli.service.ros2_services import Ros2Services

    return Ros2Services(graph)


@verb("list", "rostether service list\nrostether service list -n /demo_board")
@option_group("wanted", ServiceListing)
@graph_options()
async def list_services(wanted: ServiceListing, graph: GraphOptions) -> None:
    """List all services, or those in a namespace."""
    await services_of(graph).list_services(wanted)


@verb("type", "rostether service type /set_led")
@_service_argument
@graph_options()
async def type_of(service: str, graph: GraphOptions) -> None:
    """Print the type of a service."""
    await services_of(graph).type_of(service)


@verb("uri", "rostether service uri /set_led")
@_service_argument
@graph_options()
async def uri_of(service: str, graph: GraphOptions) -> None:
    """Print the URI (rosrpc://host:port) of a service."""
    refuse_ros2(graph, "service uri", "ROS 2 services have no URI; use `rostether service info`")
    from rostether.cli.service.ros1_services import Ros1Services

    await Ros1Services(graph).uri_of(service)


@verb("node", "rostether service node /set_led")
@_service_argument
@graph_options()
async def node_of(service: str, graph: GraphOptions) -> None:
    """Print the node that offers a service."""
    await services_of(graph).node_of(service)


@verb("args", "rostether service args /set_led")
@_service_argument
@msg_path_option
@graph_options()
async def args(service: str, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
    """Print the names of a service's arguments."""
    await services_of(graph).args(service, msg_paths)


@verb("info", "rostether service info /set_led")
@_service_argument
@json_option
@msg_path_option
@graph_options()
async def info(service: str, as_json: bool, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
    """Show which node offers a service, its type and its arguments.

    With --ros2, show its type and the numbers of its clients and servers.
    """
    await services_of(graph).info(service, msg_paths, as_json=as_json)


@verb("find", "rostether service find std_srvs/SetBool")
@click.argument("type_name", metavar="TYPE", shell_complete=complete_service_types)
@graph_options()
async def find(type_name: str, graph: GraphOptions) -> None:
    """List the services of a type."""
    await services_of(graph).find(type_name)


@verb(
    "call",
    """
    rostether service call /set_led "data: true"
    rostether service call /set_led true
    rostether service call --wait --timeout 5 /set_led "{data: false}"
    rostether service call --ros2 /set_led std_srvs/srv/SetBool "{data: true}"
    """,
    context_settings={"ignore_unknown_options": True},
)
@click.argument("service", shell_complete=complete_services)
@click.argument("arguments", nargs=-1, metavar="[ARGUMENTS]...")
@option_group("options", CallOptions)
@graph_options(allow=True)
async def call(service: str, arguments: tuple[str, ...], options: CallOptions, graph: GraphOptions) -> None:
    """Call a service and print its response.

    ARGUMENTS are YAML: one mapping of the request's fields, or the value of each field in order. Without
    them, requests come from a pipe, in YAML documents that are separated by ---. With --ros2 you can give the
    service's type first; missing fields have their defaults.
    """
    await services_of(graph).call(service, arguments, options)
