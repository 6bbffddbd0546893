"""`rostether rosbridge`, and the nodes rosbridge_websocket and rosapi_node as roles."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec.structs import replace

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.gateway.gateways import (
    GatewayGraph,
    NodeNaming,
    Report,
    certificate_files,
    is_true,
    joined_as,
    open_gateway_graph,
    private_parameters,
    read_gateway_arguments,
    report_reach,
    role_gateway_graph,
    serve_gateway,
    whole_number,
)
from rostether.cli.gateway.options import (
    DEFAULT_ADDRESS,
    NO_OPTIONS,
    TOKEN_VARIABLE,
    GatewayOptions,
    access_options,
    client_options,
    read_encryption,
    read_listen_address,
)
from rostether.cli.role.node import RoleVerb, node_words, run_role
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError, DefinitionError, GraphError
from rostether.extras import install_command
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.settings import DEFAULT_PORT, RosbridgeLimits, RosbridgeSettings
from rostether.gateways.websocket.settings import DEFAULT_HOST
from rostether.graph.ports import Graph, Level
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.block_end import closed_at_end
from rostether.names.remap import Arguments

if TYPE_CHECKING:
    from rostether.gateways.rosbridge.server import RosbridgeServer

ROSBRIDGE_NODE = "rosbridge_websocket"


@verb(
    "rosbridge",
    """
    rostether rosbridge                                   web pages on this machine, port 9090
    rostether rosbridge 9091
    rostether rosbridge 0.0.0.0:9090 --allow 192.168.1.0/24
    rostether rosbridge 0.0.0.0 --token 7f3c9a --origin https://panel.example
    rostether rosbridge --ros2 zenoh
    """,
    hints={"--port": "write the port without an option: rostether rosbridge 9091"},
)
@click.argument("words", nargs=-1, metavar="[[HOST:]PORT] [NAME:=OTHER]...")
@access_options
@graph_options(served=True)
@msg_path_option
def rosbridge(
    words: tuple[str, ...], gateways: GatewayOptions, graph: GraphOptions, msg_paths: tuple[Path, ...]
) -> None:
    """Connect web pages with roslibjs and programs with roslibpy to the graph.

    It uses the protocol of rosbridge_suite, with rosapi's services. `rostether serve --rosbridge` does the
    same and connects boards. Pages of other hosts need --origin. For other machines, give a HOST, e.g.
    0.0.0.0:9090.

    The node's name is rosbridge_websocket, or rosbridge_websocket_PORT on another port; __name:=, __ns:= and
    from:=to work as for any ROS node.
    """
    check_rosbridge()
    address, node = read_gateway_arguments(words, graph.arguments)
    options = replace(gateways, allow=graph.allow, rosbridge=address)
    serve_gateway(graph, msg_paths, partial(_opened, graph, options, node, msg_paths))


@asynccontextmanager
async def _opened(
    graph_options: GraphOptions,
    options: GatewayOptions,
    node: NodeNaming,
    msg_paths: tuple[Path, ...],
    graphs: ServedGraphs,
    report: Report,
) -> AsyncIterator[RosbridgeServer]:
    async with (
        open_gateway_graph(graphs, graph_options, msg_paths) as graph,
        rosbridge_gateway(options, graph, report, node, "`rostether rosbridge 0.0.0.0:{port}`") as server,
    ):
        yield server


@asynccontextmanager
async def rosbridge_gateway(
    options: GatewayOptions,
    gateway_graph: GatewayGraph,
    report: Report,
    naming: NodeNaming | None = None,
    remote_option: str = "--rosbridge 0.0.0.0:{port}",
) -> AsyncIterator[RosbridgeServer]:
    """Serve rosbridge at `options.rosbridge` until the end of the block.

    See `report_reach` for `remote_option`. Raises ConfigError if a package is missing, TransportOpenError if
    the port is not free, GraphError if another node has the name.
    """
    check_rosbridge()
    naming = naming or NodeNaming()
    host, port = read_listen_address(options.rosbridge or DEFAULT_ADDRESS, DEFAULT_PORT)
    encryption = await asyncio.to_thread(read_encryption, options.tls, host)
    settings = RosbridgeSettings(
        host,
        port,
        options.token,
        options.origins,
        options.allow,
        certificate=encryption.certificate,
        key=encryption.key,
    )
    name = naming.name_for(ROSBRIDGE_NODE, port, DEFAULT_PORT)
    graph = await joined_as(gateway_graph, naming, name, report)
    async with (
        closed_at_end(graph),
        rosbridge_server(graph, gateway_graph, settings, report, remote_option) as server,
    ):
        yield server


@asynccontextmanager
async def rosbridge_server(
    graph: Graph, gateway_graph: GatewayGraph, settings: RosbridgeSettings, report: Report, remote_option: str
) -> AsyncIterator[RosbridgeServer]:
    """Run a rosbridge server on a node, and report its address; see `rosbridge_gateway`."""
    from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi, offering_rosapi
    from rostether.gateways.rosbridge.server import RosbridgeServer

    style = Style.ROS2 if gateway_graph.is_ros2 else Style.ROS1
    rosapi = Rosapi(
        graph,
        gateway_graph.store,
        style=style,
        settings=settings,
        ask_type=gateway_graph.ask_service_type,
        ask_host=gateway_graph.ask_service_host,
    )
    server = RosbridgeServer(
        graph,
        gateway_graph.store,
        settings,
        style=style,
        ask_service_type=gateway_graph.ask_service_type,
        local_services=rosapi,
        report=report,
    )
    async with AsyncExitStack() as stack:
        stack.push_async_callback(server.close)
        try:
            await stack.enter_async_context(
                offering_rosapi(rosapi, gateway_graph.join, graph, gateway_graph.is_live)
            )
        except (DefinitionError, GraphError) as error:
            # The server itself answers its clients' calls of rosapi's services.
            report(Level.INFO, f"rosbridge: only its own clients can call rosapi's services: {error}")
        await server.start()
        report(Level.INFO, f"rosbridge: web pages and programs connect to {server.uri}")
        report_reach("rosbridge", settings.host, settings.port, settings.token, remote_option, report)
        yield server


def check_rosbridge() -> None:
    """Raise ConfigError if the extra is not installed."""
    if find_spec("cbor2") is None:
        raise ConfigError(f"rosbridge support is not installed; run: {install_command('rosbridge')}")


@verb(
    "rosbridge-websocket",
    """
    rostether role rosbridge-websocket
    rostether role rosbridge-websocket _port:=9091 _address:=0.0.0.0
    """,
    cls=RoleVerb,
)
@client_options
@node_words
async def rosbridge_websocket(arguments: tuple[str, ...], gateways: GatewayOptions) -> None:
    """Serve web pages, like rosbridge_websocket.

    Parameters: ~port (9090), ~address (loopback; 0.0.0.0 for other machines), ~websocket_path,
    ~max_message_size, ~use_compression, ~ssl, ~certfile, ~keyfile, ~authenticate (with ROSTETHER_TOKEN),
    ~topics_glob, ~services_glob, ~params_glob. Other parameters of rosbridge_websocket have no effect.
    """
    check_rosbridge()
    await run_role(ROSBRIDGE_NODE, arguments, partial(_main, gateways=gateways))


async def _main(graph: TypedGraph, arguments: Arguments, gateways: GatewayOptions) -> None:
    parameters = await node_parameters(graph, arguments.rest)
    settings = read_settings(parameters, gateways)
    gateway_graph = role_gateway_graph(arguments, graph.store)
    report = ConsoleReporter().report
    async with rosbridge_server(graph.raw, gateway_graph, settings, report, "address 0.0.0.0") as server:
        await graph.raw.set_param("~actual_port", server.port)
        await graph.raw.wait_closed()


async def node_parameters(graph: TypedGraph, words: Sequence[str]) -> dict[str, Any]:
    """Return the private parameters; options such as `--port 9091` override them, as in the original."""
    parameters = await private_parameters(graph)
    rest = iter(words)
    for word in rest:
        if word.startswith("--"):
            name, equals, value = word[2:].partition("=")
            parameters[name] = value if equals else next(rest, "")
    return parameters


def read_settings(parameters: Mapping[str, Any], options: GatewayOptions = NO_OPTIONS) -> RosbridgeSettings:
    """Return the settings from the node's parameters and options. Raises ConfigError naming the parameter."""
    if is_true(parameters, "authenticate") and not options.token:
        raise ConfigError(f"~authenticate needs a token; set {TOKEN_VARIABLE} in the environment of the node")
    is_secure = is_true(parameters, "ssl") or bool(parameters.get("certfile"))
    certificate, key = certificate_files(parameters, "ssl") if is_secure else ("", "")
    max_bytes = whole_number(parameters, "max_message_size", 0)
    return RosbridgeSettings(
        host=str(parameters.get("address") or DEFAULT_HOST),
        port=whole_number(parameters, "port", DEFAULT_PORT),
        token=options.token,
        origins=options.origins,
        path="" if parameters.get("websocket_path") in (None, "/") else str(parameters["websocket_path"]),
        limits=RosbridgeLimits(message_bytes=max_bytes) if max_bytes else RosbridgeLimits(),
        deflate=is_true(parameters, "use_compression"),
        certificate=certificate,
        key=key,
        fragment_bytes=whole_number(parameters, "fragment_size", 0) or None,
        topics_glob=_globs(parameters, "topics_glob"),
        services_glob=_globs(parameters, "services_glob"),
        params_glob=_globs(parameters, "params_glob"),
    )


def _globs(parameters: Mapping[str, Any], name: str) -> tuple[str, ...] | None:
    """Return the names in `[/a, '/b*']`; an empty or missing list means everything."""
    value = parameters.get(name)
    parts = value if isinstance(value, list) else str(value or "").strip().strip("[]").split(",")
    globs = tuple(text for part in parts if (text := str(part).strip().strip("'\"")))
    return globs or None


@verb("rosapi-node", "rostether role rosapi-node", cls=RoleVerb)
@node_words
async def rosapi_node(arguments: tuple[str, ...]) -> None:
    """Offer services that query the graph and access parameters, like rosapi_node.

    Parameters: ~topics_glob, ~services_glob, ~params_glob. `rostether rosbridge` has the same services.
    """
    check_rosbridge()
    await run_role("rosapi", arguments, _run_rosapi)


async def _run_rosapi(graph: TypedGraph, arguments: Arguments) -> None:
    from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi

    gateway_graph = role_gateway_graph(arguments, graph.store)
    rosapi = Rosapi(
        graph.raw,
        gateway_graph.store,
        settings=read_settings(await node_parameters(graph, arguments.rest)),
        ask_type=gateway_graph.ask_service_type,
        ask_host=gateway_graph.ask_service_host,
    )
    await rosapi.offer(graph.raw)
    await graph.raw.wait_closed()
