"""`rostether foxglove`, and the node foxglove_bridge as a role."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec.structs import replace

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.ros1_access import type_store
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.gateway.gateways import (
    GatewayGraph,
    NodeNaming,
    Report,
    certificate_files,
    is_true,
    joined_as,
    private_parameters,
    read_gateway_arguments,
    report_reach,
    role_gateway_graph,
    ros1_gateway_graph,
    serve_gateway,
    whole_number,
)
from rostether.cli.gateway.options import (
    NO_OPTIONS,
    GatewayOptions,
    client_options,
    read_encryption,
    read_listen_address,
    viewer_access_options,
)
from rostether.cli.role.node import RoleVerb, node_words, run_role
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.gateways.foxglove.settings import (
    CAPABILITIES,
    DEFAULT_PORT,
    FoxgloveLimits,
    FoxgloveSettings,
    NameFilter,
)
from rostether.gateways.websocket.settings import DEFAULT_HOST
from rostether.graph.ports import Graph, Level
from rostether.mechanisms.block_end import closed_at_end
from rostether.names.remap import Arguments

if TYPE_CHECKING:
    from rostether.gateways.foxglove.gateway import DashboardParts, FoxgloveGateway
    from rostether.graph.typed_graph import TypedGraph

FOXGLOVE_NODE = "foxglove_bridge"


@verb(
    "foxglove",
    """
    rostether foxglove                                   Foxglove on this machine: ws://localhost:8765
    rostether foxglove 8766
    rostether foxglove 0.0.0.0:8765 --allow 192.168.1.0/24
    rostether foxglove 0.0.0.0 --token 7f3c9a
    rostether foxglove --ros2 zenoh
    """,
    hints={"--port": "write the port without an option: rostether foxglove 8766"},
)
@click.argument("words", nargs=-1, metavar="[[HOST:]PORT] [NAME:=OTHER]...")
@viewer_access_options
@graph_options(served=True)
@msg_path_option
def foxglove(
    words: tuple[str, ...], gateways: GatewayOptions, graph: GraphOptions, msg_paths: tuple[Path, ...]
) -> None:
    """Connect Foxglove to the graph, to show topics, publish and call services.

    Open ws://localhost:8765 in Foxglove or another viewer of its WebSocket protocol. `rostether serve
    --foxglove` does the same and connects boards. For other machines, give a HOST, e.g. 0.0.0.0:8765.

    The node's name is foxglove_bridge, or foxglove_bridge_PORT on another port; __name:=, __ns:= and
    from:=to work as for any ROS node.
    """
    address, node = read_gateway_arguments(words, graph.arguments)
    settings = read_settings(address, replace(gateways, allow=graph.allow))
    remote_option = "`rostether foxglove 0.0.0.0:{port}`"
    serve_gateway(graph, msg_paths, partial(foxglove_gateway, settings, node, remote_option, msg_paths))


@verb(
    "foxglove-bridge",
    """
    rostether role foxglove-bridge
    rostether role foxglove-bridge _port:=8766 _address:=0.0.0.0
    """,
    cls=RoleVerb,
)
@client_options
@node_words
async def foxglove_bridge(arguments: tuple[str, ...], gateways: GatewayOptions) -> None:
    """Serve Foxglove, like foxglove_bridge.

    Parameters: ~port (8765), ~address (loopback; 0.0.0.0 for other machines), ~topic_whitelist,
    ~service_whitelist, ~param_whitelist, ~client_topic_whitelist, ~capabilities, ~send_buffer_limit, ~tls,
    ~certfile, ~keyfile. Other parameters of foxglove_bridge have no effect.
    """
    await run_role(FOXGLOVE_NODE, arguments, partial(_main, gateways=gateways))


@asynccontextmanager
async def foxglove_gateway(
    settings: FoxgloveSettings,
    node: NodeNaming,
    remote_option: str,
    msg_paths: Sequence[Path],
    graphs: ServedGraphs,
    report: Report,
) -> AsyncIterator[FoxgloveGateway]:
    """Serve Foxglove until the end of the block; see `report_reach` for `remote_option`.

    Raises ConfigError, TransportOpenError if the port is not free, GraphError if another node has the name.
    """
    gateway_graph = with_ros1_types(graphs, msg_paths)
    name = node.name_for(FOXGLOVE_NODE, settings.port, DEFAULT_PORT)
    graph = await joined_as(gateway_graph, node, name, report)
    async with (
        closed_at_end(graph),
        _reported_gateway(graph, gateway_graph, settings, report, remote_option) as gateway,
    ):
        yield gateway


def read_settings(address: str, options: GatewayOptions) -> FoxgloveSettings:
    """Return the typed options as settings. Raises ConfigError."""
    host, port = read_listen_address(address, DEFAULT_PORT)
    encryption = read_encryption(options.tls, host)
    return FoxgloveSettings(
        host,
        port,
        token=options.token,
        view_token=options.view_token,
        origins=options.origins,
        allow=options.allow,
        certificate=encryption.certificate,
        key=encryption.key,
    )


def settings_of_parameters(
    parameters: Mapping[str, Any], options: GatewayOptions = NO_OPTIONS
) -> FoxgloveSettings:
    """Return the settings from the node's parameters and options. Raises ConfigError naming the parameter."""
    certificate, key = certificate_files(parameters, "tls") if is_true(parameters, "tls") else ("", "")
    wanted = parameters.get("capabilities")
    if wanted is not None and not isinstance(wanted, list):
        raise ConfigError(f"~capabilities must be a list, for example [{', '.join(CAPABILITIES)}]")
    waiting_bytes = whole_number(parameters, "send_buffer_limit", 0)
    return FoxgloveSettings(
        host=str(parameters.get("address") or DEFAULT_HOST),
        port=whole_number(parameters, "port", DEFAULT_PORT),
        token=options.token,
        origins=options.origins,
        certificate=certificate,
        key=key,
        capabilities=tuple(each for each in CAPABILITIES if wanted is None or each in wanted),
        topics=_filter(parameters, "topic_whitelist"),
        services=_filter(parameters, "service_whitelist"),
        parameters=_filter(parameters, "param_whitelist"),
        client_topics=_filter(parameters, "client_topic_whitelist"),
        limits=FoxgloveLimits(waiting_bytes=waiting_bytes or FoxgloveLimits().waiting_bytes),
    )


async def _main(graph: TypedGraph, arguments: Arguments, gateways: GatewayOptions) -> None:
    settings = settings_of_parameters(await private_parameters(graph), gateways)
    gateway_graph = role_gateway_graph(arguments, graph.store)
    async with _reported_gateway(
        graph.raw, gateway_graph, settings, ConsoleReporter().report, "address 0.0.0.0"
    ) as gateway:
        await gateway.wait_ended()


def with_ros1_types(graphs: ServedGraphs, msg_paths: Sequence[Path]) -> GatewayGraph:
    """Return the graphs with ROS 1 definitions, even on ROS 2: Foxglove's panels need them for times.

    Raises ConfigError for a missing folder.
    """
    store = type_store(msg_paths)
    if graphs.types is not None:
        from rostether.ros2.rcl_interfaces import rcl_interfaces

        rcl_interfaces().add_to(store.registry)
    if graphs.ros1 is not None:
        gateway_graph = ros1_gateway_graph(graphs.join, store, graphs.ros1)
    else:
        gateway_graph = GatewayGraph(graphs.join, store)
    return replace(gateway_graph, msg_paths=msg_paths)


@asynccontextmanager
async def _reported_gateway(
    graph: Graph, gateway_graph: GatewayGraph, settings: FoxgloveSettings, report: Report, remote_option: str
) -> AsyncIterator[FoxgloveGateway]:
    async with gateway_on(graph, gateway_graph, settings, report) as gateway:
        report(Level.INFO, f"foxglove: open a connection to {gateway.url} in Foxglove")
        report_reach("foxglove", settings.host, settings.port, settings.token, remote_option, report)
        yield gateway


def gateway_on(
    graph: Graph,
    gateway_graph: GatewayGraph,
    settings: FoxgloveSettings,
    report: Report,
    dashboard: DashboardParts | None = None,
) -> FoxgloveGateway:
    """Return a gateway on a node, to be used as a context manager."""
    from rostether.gateways.foxglove.gateway import FoxgloveGateway

    return FoxgloveGateway(
        graph,
        gateway_graph.store,
        settings,
        find_service_type=gateway_graph.ask_service_type,
        find_packages=partial(_package_folders, gateway_graph.msg_paths),
        report=report,
        dashboard=dashboard,
    )


def _filter(parameters: Mapping[str, Any], name: str) -> NameFilter:
    given = parameters.get(name)
    if given is None:
        return NameFilter()
    if not isinstance(given, list) or not all(isinstance(each, str) for each in given):
        raise ConfigError(f"~{name} must be a list of regular expressions, for example ['/camera/.*']")
    return NameFilter() if ".*" in given else NameFilter.of(given, f"~{name}")


def _package_folders(msg_paths: Sequence[Path]) -> Mapping[str, Path]:
    """Return the folders of all packages by name; those of --msg-path take precedence."""
    from rostether.msgdef.ros2.definition_files import install_prefixes
    from rostether.packages.locate import installed_packages, package_folders
    from rostether.packages.search_path import find_packages

    given = find_packages([each.expanduser() for each in msg_paths])
    # If a ROS 2 installation is sourced, it contains meshes of robots.
    return installed_packages(install_prefixes(os.environ)) | package_folders(os.environ, Path.cwd()) | given
