"""`rostether node` on a ROS 2 graph, with the output of `ros2 node`."""

from __future__ import annotations

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros1_only
from rostether.cli.access.ros2_tool_node import ToolNode, asked
from rostether.cli.shell.output import write_json, write_line, write_result
from rostether.errors import UnknownNameError
from rostether.mechanisms.text import did_you_mean, escape_line
from rostether.names.graph_name import is_hidden, is_in_namespace
from rostether.ros2.endpoint_info import EndpointKind
from rostether.ros2.graph_view import GraphView, one_or_all

_SECTIONS = {
    "Subscribers": EndpointKind.SUBSCRIPTION,
    "Publishers": EndpointKind.PUBLISHER,
    "Service Servers": EndpointKind.SERVER,
    "Service Clients": EndpointKind.CLIENT,
}
_ACTION_SECTIONS = {"Action Servers": EndpointKind.SERVER, "Action Clients": EndpointKind.CLIENT}
_ACTION_SERVICE = "/_action/send_goal"


class Ros2Nodes:
    """The nodes of a ROS 2 graph; each method is a whole command."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph

    async def list_nodes(
        self, namespace: str, *, uris_only: bool, with_uris: bool, count_nodes: bool, as_json: bool
    ) -> None:
        """Print the nodes."""
        refuse_ros1_only(uris_only=uris_only)
        view = await asked(self._graph, lambda tool: tool.settled_snapshot())
        within = full_node_name(namespace.rstrip("/"))
        names = [
            name
            for name in sorted(view.nodes)
            if (with_uris or not is_hidden(name)) and is_in_namespace(name, within)
        ]
        if count_nodes:
            write_line(str(len(names)))
            return
        for name in names:
            write_result({"node": name}, escape_line(name), as_json=as_json)

    async def info(self, names: tuple[str, ...], *, quiet: bool, with_hidden: bool, as_json: bool) -> None:
        """Print what nodes publish, subscribe to, serve and call. Raises UnknownNameError."""
        refuse_ros1_only(quiet=quiet)
        full_names = [full_node_name(name) for name in names]

        async def ask(tool: ToolNode) -> GraphView:
            await tool.snapshot_when(lambda seen: set(full_names) <= set(seen.nodes))
            return await tool.settled_snapshot()

        view = await asked(self._graph, ask)
        for name in full_names:
            if name not in view.nodes:
                hint = did_you_mean(name, view.nodes) or "`rostether node list` shows all nodes"
                raise UnknownNameError(f"Unable to find node '{name}'; {hint}")
            _write_info(name, _sections(view, name, with_hidden=with_hidden), as_json=as_json)


def _write_info(name: str, sections: dict[str, dict[str, list[str]]], *, as_json: bool) -> None:
    if as_json:
        records = {
            title.lower().replace(" ", "_"): [
                {"name": each, "type": one_or_all(types)} for each, types in found.items()
            ]
            for title, found in sections.items()
        }
        write_json({"node": name, **records})
        return
    write_line(escape_line(name))
    for title, found in sections.items():
        write_line(f"  {title}:")
        write_line("\n".join(escape_line(f"    {each}: {', '.join(types)}") for each, types in found.items()))


def full_node_name(name: str) -> str:
    """Return a node's full name: `board` is `/board`."""
    return f"/{name.lstrip('/')}"


def _sections(view: GraphView, node: str, *, with_hidden: bool) -> dict[str, dict[str, list[str]]]:
    """Return the names of a node's endpoints with their types, by the title of their section."""
    found = {
        title: {name: types for name, types in view.of_node(kind, node) if with_hidden or not is_hidden(name)}
        for title, kind in _SECTIONS.items()
    }
    for title, kind in _ACTION_SECTIONS.items():
        found[title] = {
            name.removesuffix(_ACTION_SERVICE): [each.removesuffix("_SendGoal") for each in types]
            for name, types in view.of_node(kind, node)
            if name.endswith(_ACTION_SERVICE)
        }
    return found
