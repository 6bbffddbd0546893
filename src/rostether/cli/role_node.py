"""Being a node by role: one of ROS's standard nodes, with the arguments that any ROS node takes."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rostether.cli.graph_access import no_master, read_environment, special_arguments
from rostether.errors import MasterUnreachableError
from rostether.names.remap import Arguments, parse_arguments

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph

NODE_SETTINGS = {"ignore_unknown_options": True}
"""For commands with a node's arguments: `-0.1` is a number there, no option."""


def node_arguments(words: Sequence[str]) -> Arguments:
    """Sort a node's words: remappings, private parameters, and the rest. Raises ConfigError."""
    return parse_arguments(words)


@asynccontextmanager
async def role_node(arguments: Arguments, default_name: str) -> AsyncIterator[TypedGraph]:
    """Be the node, `default_name` unless `__name:=` says otherwise; its private parameters are set first.

    Raises MasterUnreachableError with what to do next, InvalidNameError, ConfigError.
    """
    from rostether.graph.typed_graph import TypedGraph
    from rostether.msgdef.registry import Registry
    from rostether.ros1.node.node import join_ros1
    from rostether.serde.store import TypeStore

    environment = read_environment()
    name = special_arguments().get("__name", default_name)
    try:
        graph = await join_ros1(
            name,
            environment=environment,
            namespace=environment.namespace,
            remappings=arguments.remappings,
        )
    except MasterUnreachableError as error:
        raise no_master(environment, error) from error
    try:
        for parameter, value in arguments.private_params.items():
            await graph.set_param(f"~{parameter}", value)
        yield TypedGraph(graph, TypeStore(Registry.from_environment()))
    finally:
        await graph.close()
