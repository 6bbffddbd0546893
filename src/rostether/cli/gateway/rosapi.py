"""rosapi_node as a role, for launch files that start it beside rosbridge_websocket."""

from __future__ import annotations

import click

from rostether.cli.access.ros1_access import joining_ros1
from rostether.cli.gateway.gateways import check_rosbridge, ros1_gateway_graph
from rostether.cli.gateway.rosbridge import node_parameters, read_settings
from rostether.cli.role.node import NODE_SETTINGS, node_environment, run_role
from rostether.cli.shell.verbs import Verb
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments


@click.command("rosapi-node", cls=Verb, context_settings=NODE_SETTINGS, examples="rostether role rosapi-node")
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[NAME:=VALUE]...")
def rosapi_node(arguments: tuple[str, ...]) -> None:
    """Offer services that query the graph and access parameters, like rosapi_node.

    Parameters: ~topics_glob, ~services_glob, ~params_glob. `rostether rosbridge` offers the same by itself.
    """
    check_rosbridge()
    run_role("rosapi", arguments, _main)


async def _main(graph: TypedGraph, arguments: Arguments) -> None:
    from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi

    environment = node_environment(arguments)
    on = ros1_gateway_graph(joining_ros1(environment), graph.store, environment)
    rosapi = Rosapi(
        graph.raw,
        on.store,
        settings=read_settings(await node_parameters(graph, arguments.rest)),
        ask_type=on.ask_service_type,
        ask_host=on.ask_service_host,
    )
    await rosapi.offer(graph.raw)
    await graph.raw.wait_closed()
