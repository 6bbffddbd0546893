"""`rostether service list|type|uri|node|args|info|find`: lists and shows services."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.access.completions import complete_service_types, complete_services
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.ros2_habits import daemon_habits
from rostether.cli.service.services import ServiceListing, services_of
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import Verb

_service_argument = click.argument("service", shell_complete=complete_services)
_listing_options = option_group(
    "wanted",
    ServiceListing,
    (
        click.argument("namespace", required=False, shell_complete=complete_services),
        click.option("-n", "--nodes", is_flag=True, help="Also print the nodes that offer them."),
        click.option("-t", "--show-types", is_flag=True, help="With --ros2, show types."),
        click.option("-c", "--count-services", is_flag=True, help="Print only the number."),
        click.option(
            "--include-hidden-services",
            "with_hidden",
            is_flag=True,
            help="With --ros2, also hidden services (_name).",
        ),
        json_option,
    ),
)


@click.command("list", cls=Verb, examples="rostether service list\nrostether service list -n /demo_board")
@_listing_options
@graph_options()
@daemon_habits
def list_services(wanted: ServiceListing, graph: GraphOptions) -> None:
    """List all services, or those in a namespace."""
    services_of(graph).list_services(wanted)


@click.command("type", cls=Verb, examples="rostether service type /set_led")
@_service_argument
@graph_options()
@daemon_habits
def type_of(service: str, graph: GraphOptions) -> None:
    """Print the type of a service."""
    services_of(graph).type_of(service)


@click.command("uri", cls=Verb, examples="rostether service uri /set_led")
@_service_argument
@graph_options()
@daemon_habits
def uri_of(service: str, graph: GraphOptions) -> None:
    """Print the URI (rosrpc://host:port) of a service."""
    services_of(graph).uri_of(service)


@click.command("node", cls=Verb, examples="rostether service node /set_led")
@_service_argument
@graph_options()
@daemon_habits
def node_of(service: str, graph: GraphOptions) -> None:
    """Print the node that offers a service."""
    services_of(graph).node_of(service)


@click.command("args", cls=Verb, examples="rostether service args /set_led")
@_service_argument
@msg_path_option
@graph_options()
@daemon_habits
def args(service: str, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
    """Print the names of a service's arguments."""
    services_of(graph).args(service, msg_paths)


@click.command("info", cls=Verb, examples="rostether service info /set_led")
@_service_argument
@json_option
@msg_path_option
@graph_options()
@daemon_habits
def info(service: str, as_json: bool, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
    """Show which node offers a service, its type and its arguments."""
    services_of(graph).info(service, msg_paths, as_json=as_json)


@click.command("find", cls=Verb, examples="rostether service find std_srvs/SetBool")
@click.argument("type_name", metavar="TYPE", shell_complete=complete_service_types)
@graph_options()
@daemon_habits
def find(type_name: str, graph: GraphOptions) -> None:
    """List the services of a type."""
    services_of(graph).find(type_name)
