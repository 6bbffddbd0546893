"""`node list|info` on a ROS 2 graph, in `ros2 node`'s words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rostether.cli.access.ros2_tool_node import ToolNode, asked
from rostether.cli.access.ros2_view import GraphView, is_hidden
from rostether.cli.access.ros_choice import Middleware
from rostether.cli.shell.output import one_line, write_json, write_line
from rostether.errors import UnknownNameError
from rostether.ros2.endpoint_info import EndpointKind

_SECTIONS = {
    "Subscribers": EndpointKind.SUBSCRIPTION,
    "Publishers": EndpointKind.PUBLISHER,
    "Service Servers": EndpointKind.SERVER,
    "Service Clients": EndpointKind.CLIENT,
}
_ACTION_SECTIONS = {"Action Servers": EndpointKind.SERVER, "Action Clients": EndpointKind.CLIENT}
_ACTION_SERVICE = "/_action/send_goal"


def list_nodes(
    middleware: Middleware, namespace: str, *, with_hidden: bool, count_only: bool, as_json: bool
) -> None:
    """Print the nodes."""
    view = asked(middleware, lambda tool: tool.look_well())
    prefix = f"/{namespace.strip('/')}".rstrip("/") + "/"
    names = [
        name
        for name in sorted(view.nodes)
        if (with_hidden or not is_hidden(name)) and f"{name}/".startswith(prefix)
    ]
    if count_only:
        write_line(str(len(names)))
        return
    for name in names:
        if as_json:
            write_json({"node": name})
        else:
            write_line(one_line(name))


def info(middleware: Middleware, nodes: tuple[str, ...], *, with_hidden: bool, as_json: bool) -> None:
    """Print what nodes publish, subscribe to, serve and call. Raises UnknownNameError."""
    names = [full_node_name(node) for node in nodes]

    async def ask(tool: ToolNode) -> GraphView:
        await tool.look_until(lambda seen: set(names) <= set(seen.nodes))
        return await tool.look_well()

    view = asked(middleware, ask)
    for name in names:
        if name not in view.nodes:
            raise unknown_node(name)
        sections = _sections(view, name, with_hidden=with_hidden)
        if as_json:
            write_json({"node": name, **{_key(title): _records(found) for title, found in sections.items()}})
            continue
        write_line(one_line(name))
        for title, found in sections.items():
            write_line(f"  {title}:")
            write_line("\n".join(one_line(f"    {each}: {', '.join(types)}") for each, types in found))


def full_node_name(name: str) -> str:
    """Return a node's full name as it was meant: `board` is `/board`."""
    return f"/{name.lstrip('/')}"


def unknown_node(name: str) -> UnknownNameError:
    """Return the error for a node that is not there."""
    return UnknownNameError(f"Unable to find node '{name}'; `rostether node list` shows those there are")


def _sections(view: GraphView, node: str, *, with_hidden: bool) -> dict[str, list[tuple[str, list[str]]]]:
    found = {
        title: [
            (name, types) for name, types in view.of_node(kind, node) if with_hidden or not is_hidden(name)
        ]
        for title, kind in _SECTIONS.items()
    }
    return found | {title: list(_actions(view, kind, node)) for title, kind in _ACTION_SECTIONS.items()}


def _actions(view: GraphView, kind: EndpointKind, node: str) -> Iterator[tuple[str, list[str]]]:
    for name, types in view.of_node(kind, node):
        if name.endswith(_ACTION_SERVICE):
            plain = (each.replace("::dds_::", "/").replace("::", "/").rstrip("_") for each in types)
            yield name.removesuffix(_ACTION_SERVICE), [each.removesuffix("_SendGoal") for each in plain]


def _key(title: str) -> str:
    return title.lower().replace(" ", "_")


def _records(found: list[tuple[str, list[str]]]) -> list[dict[str, Any]]:
    return [{"name": name, "type": types[0] if len(types) == 1 else types} for name, types in found]
