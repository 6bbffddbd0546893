"""Being a node by role: one of ROS's standard nodes, with the arguments that any ROS node takes."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions, ros_arguments
from rostether.cli.access.ros1_access import read_environment
from rostether.cli.shell.output import warn
from rostether.mechanisms.waiting import wait_for_master
from rostether.names.remap import Arguments, parse_arguments
from rostether.ros1.environment import RosEnvironment

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph

# For commands with a node's arguments: `-0.1` is a number there, no option.
NODE_SETTINGS = {"ignore_unknown_options": True}


def node_arguments(words: Sequence[str]) -> Arguments:
    """Sort a node's words: remappings, private parameters, ROS arguments and the rest. Raises ConfigError."""
    return replace(parse_arguments(words), special=dict(ros_arguments()))


def node_environment(arguments: Arguments) -> RosEnvironment:
    """Return the ROS environment of a node. Raises ConfigError."""
    return read_environment(GraphOptions(arguments=arguments.special))


@asynccontextmanager
async def role_node(arguments: Arguments, default_name: str) -> AsyncIterator[TypedGraph]:
    """Be the node, `default_name` unless `__name:=` says otherwise; its private parameters are set first.

    As rospy's nodes do, it waits for the master. Raises InvalidNameError, ConfigError.
    """
    from rostether.graph.typed_graph import TypedGraph
    from rostether.msgdef.registry import Registry
    from rostether.ros1.node.node import join_ros1
    from rostether.serde.store import TypeStore

    environment = node_environment(arguments)
    name = arguments.special.get("__name", default_name)
    graph = await wait_for_master(
        lambda: join_ros1(
            name,
            environment=environment,
            namespace=environment.namespace,
            remappings=arguments.remappings,
        ),
        lambda _: warn(f"waiting for a ROS master at {environment.master_uri}"),
    )
    try:
        for parameter, value in arguments.private_params.items():
            await graph.set_param(f"~{parameter}", value)
        yield TypedGraph(graph, TypeStore(Registry.from_environment()))
    finally:
        await graph.close()


def run_role(
    default_name: str, words: Sequence[str], main: Callable[[TypedGraph, Arguments], Awaitable[None]]
) -> None:
    """Be a node until `main` ends, the node is shut down, or the process is.

    `main` gets the graph and the node's arguments.
    """
    from rostether.cli.shell.running import run

    arguments = node_arguments(words)

    async def until_ended() -> None:
        async with role_node(arguments, default_name) as graph:
            working = asyncio.ensure_future(main(graph, arguments))
            leaving = asyncio.ensure_future(graph.raw.wait_closed())
            try:
                await asyncio.wait([working, leaving], return_when=asyncio.FIRST_COMPLETED)
                if working.done():
                    await working
            finally:
                working.cancel()
                leaving.cancel()
                await asyncio.wait([working, leaving])

    run(until_ended(), is_service=True)
