"""Shell completion of names in the running graph and of known types."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from rostether.cli.access.graph_options import GraphOptions, chosen_middleware
from rostether.cli.shell.completion import beginning
from rostether.errors import RostetherError

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry
    from rostether.ros1.node.master_client import MasterClient
    from rostether.ros2.graph_view import GraphView

# The longest wait after Tab; a master on this machine answers in milliseconds.
ROS1_TIMEOUT_S = 1.0

# DDS takes a second or two to discover other nodes.
ROS2_TIMEOUT_S = 3.0


def complete_topics(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the topics that begin with the typed text."""
    return _complete(ctx, _topics, lambda view: view.topics(), incomplete)


def complete_fields(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the topics, and the fields of a topic, that begin with the typed text."""

    async def names(client: MasterClient) -> Iterable[str]:
        found = field_names(_registry(ctx), await client.topic_types(), incomplete)
        return {*await _topics(client), *found}

    return _complete(ctx, names, lambda view: view.topics(), incomplete)


def complete_topic_type(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Return the type of the topic that was typed before, or the types that begin with the typed text."""
    topic = str(ctx.params.get("topic") or "").lstrip("/")

    async def names(client: MasterClient) -> Iterable[str]:
        types = await client.topic_types()
        return [kind for name, kind in types.items() if name.lstrip("/") == topic]

    known = _complete(ctx, names, lambda _: (), incomplete)
    return known or complete_message_types(ctx, param, incomplete)


def complete_nodes(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the nodes that begin with the typed text."""
    from rostether.ros1.node.node_queries import node_names

    return _complete(ctx, node_names, _nodes, incomplete)


def complete_services(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the services that begin with the typed text."""
    return _complete(ctx, _services, lambda view: view.services(), incomplete)


def complete_params(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the parameters that begin with the typed text."""
    # On ROS 2, the first argument of the commands is a node.
    return _complete(ctx, lambda client: client.param_names(), _nodes, incomplete)


def field_names(registry: Registry, types: Mapping[str, str], typed: str) -> list[str]:
    """Return the whole paths of the fields that may follow in a typed path; `types` has the topics' types."""
    topic = max((each for each in types if typed.startswith(f"{each}/")), key=len, default=None)
    if topic is None:
        return []
    *before, _ = typed[len(topic) + 1 :].split("/")
    try:
        fields = registry.message(types[topic]).fields
        for name in before:
            fields = registry.message(next(each.type.base for each in fields if each.name == name)).fields
    except (RostetherError, StopIteration):
        return []
    return ["/".join((topic, *before, each.name)) for each in fields]


def complete_message_types(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the message types that begin with the typed text."""
    return beginning(_registry(ctx).messages(), incomplete)


def complete_service_types(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the service types that begin with the typed text."""
    return beginning(_registry(ctx).services(), incomplete)


def complete_ports(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the serial ports that begin with the typed text; without any, the shell completes files."""
    from rostether.transports.opening import list_serial_ports

    ports = [CompletionItem(port.path, help=port.description) for port in list_serial_ports()]
    found = [each for each in ports if each.value.startswith(incomplete)]
    # Shells do not complete the path after `pty:` or `sim:`.
    return found or [CompletionItem(incomplete, type="file")]


def complete_packages(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the packages that have definitions and begin with the typed text."""
    from rostether.msgdef.registry import Registry

    return beginning(Registry.from_environment().packages(), incomplete)


def _registry(ctx: click.Context) -> Registry:
    if _graph(ctx).ros2 is not None:
        from rostether.ros2.types.native_registry import NativeRegistry

        return NativeRegistry.from_environment()
    from rostether.msgdef.registry import Registry

    return Registry.from_environment()


def _graph(ctx: click.Context) -> GraphOptions:
    """Return the graph that the command line selects so far."""
    ros1, ros2 = bool(ctx.params.get("ros1")), ctx.params.get("ros2")
    return GraphOptions(
        ros1=ros1, ros2=chosen_middleware(ros1=ros1, ros2=ros2), master=ctx.params.get("master")
    )


async def _topics(client: MasterClient) -> Iterable[str]:
    publishers, subscribers, _ = await client.system_state()
    return publishers.keys() | subscribers.keys()


async def _services(client: MasterClient) -> Iterable[str]:
    return (await client.system_state())[2]


def _nodes(view: GraphView) -> Iterable[str]:
    return (node for node in view.nodes if not node.rpartition("/")[2].startswith("_"))


def _complete(
    ctx: click.Context,
    names: Callable[[MasterClient], Awaitable[Iterable[str]]],
    ros2_names: Callable[[GraphView], Iterable[str]],
    incomplete: str,
) -> list[str]:
    graph = _graph(ctx)
    # Imported here, because this takes a quarter of the start time, and not all commands need it.
    import asyncio

    async def ask() -> Iterable[str]:
        if graph.ros2 is not None:
            from rostether.cli.access.ros2_tool_node import tool_node

            async with asyncio.timeout(ROS2_TIMEOUT_S), tool_node(graph, is_quiet=True) as tool:
                return ros2_names(await tool.settled_snapshot())
        from rostether.cli.access.ros1_access import master_client, read_environment

        async with asyncio.timeout(ROS1_TIMEOUT_S), master_client(read_environment(graph)) as client:
            return await names(client)

    try:
        return beginning(asyncio.run(ask()), incomplete)
    except (RostetherError, OSError):
        # A shell cannot show errors here: complete nothing.
        return []
