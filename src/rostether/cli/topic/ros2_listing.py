"""`topic list|info|type|find` on a ROS 2 graph, with the output of `ros2 topic`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from msgspec.structs import asdict

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros1_only
from rostether.cli.access.ros2_tool_node import ToolNode, asked
from rostether.cli.shell.output import write_json, write_line, write_result
from rostether.cli.topic.options import TopicListing
from rostether.errors import UnknownNameError
from rostether.mechanisms.text import counted, escape_line, unknown_topic
from rostether.names.graph_name import is_in_namespace, namespace_of
from rostether.ros2.endpoint_info import EndpointInfo, EndpointKind
from rostether.ros2.graph_view import TOPIC_KINDS, GraphView
from rostether.ros2.types.native_registry import short_name


class Ros2TopicListing:
    """The part of `Ros2Topics` that receives and sends no messages."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph

    async def list_topics(self, wanted: TopicListing) -> None:
        """Print the topics."""
        refuse_ros1_only(by_host=wanted.by_host)
        view = await asked(self._graph, lambda tool: tool.settled_snapshot())
        kinds: tuple[EndpointKind, ...] = TOPIC_KINDS
        if wanted.publishers or wanted.subscribers:
            kinds = (EndpointKind.PUBLISHER,) if wanted.publishers else (EndpointKind.SUBSCRIPTION,)
        names = view.names(kinds, with_hidden=wanted.with_hidden)
        if wanted.namespace is not None:
            namespace = f"/{wanted.namespace.strip('/')}"
            names = [name for name in names if is_in_namespace(name, namespace)]
        if wanted.as_json:
            for name in names:
                write_json(_record(view, name))
        elif wanted.count_topics:
            write_line(str(len(names)))
        elif wanted.verbose:
            if not wanted.subscribers:
                _write_counts(view, names, EndpointKind.PUBLISHER, "Published topics:", "publisher")
            if not wanted.publishers:
                _write_counts(view, names, EndpointKind.SUBSCRIPTION, "Subscribed topics:", "subscriber")
        else:
            for name in names:
                shown = f" [{', '.join(view.types(TOPIC_KINDS, name))}]" if wanted.show_types else ""
                write_line(escape_line(name + shown))

    async def info(self, topic: str, *, verbose: bool, as_json: bool) -> None:
        """Print a topic's type and the numbers of its publishers and subscribers; `verbose` lists them."""
        name, view = await _view_of(self._graph, topic)
        publishers, subscribers = (view.of(kind, name) for kind in TOPIC_KINDS)
        if as_json:
            write_json(
                {
                    **_record(view, name),
                    "publishers": [end_record(end) for end in publishers],
                    "subscribers": [end_record(end) for end in subscribers],
                }
            )
            return
        gap = "\n" if verbose else ""
        write_line(f"Type: {view.shown_type(TOPIC_KINDS, name)}{gap}")
        for title, ends in (("Publisher", publishers), ("Subscription", subscribers)):
            write_line(f"{title} count: {len(ends)}{gap}")
            if verbose:
                for end in ends:
                    write_line(f"{format_end(end)}\n")

    async def type_of(self, topic: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the types of a topic, one per line."""
        name, view = await _view_of(self._graph, topic)
        for each in view.types(TOPIC_KINDS, name):
            write_line(escape_line(each))

    async def find(self, type_name: str, *, with_hidden: bool, as_json: bool) -> None:
        """Print the topics of a type."""
        view = await asked(self._graph, lambda tool: tool.settled_snapshot())
        for name in view.topics(with_hidden=with_hidden):
            if short_name(type_name) in map(short_name, view.types(TOPIC_KINDS, name)):
                write_result({"topic": name}, escape_line(name), as_json=as_json)


def _write_counts(view: GraphView, names: list[str], kind: EndpointKind, title: str, what: str) -> None:
    write_line(title)
    for name in names:
        count = len(view.of(kind, name))
        if count:
            types = ", ".join(view.types(TOPIC_KINDS, name))
            write_line(escape_line(f" * {name} [{types}] {counted(count, what)}"))
    write_line()


def _record(view: GraphView, name: str) -> dict[str, Any]:
    return {
        "topic": name,
        "type": view.shown_type(TOPIC_KINDS, name),
        "publishers": [end.node_name for end in view.of(EndpointKind.PUBLISHER, name)],
        "subscribers": [end.node_name for end in view.of(EndpointKind.SUBSCRIPTION, name)],
    }


async def _view_of(graph: GraphOptions, topic: str) -> tuple[str, GraphView]:
    """Return a topic's full name and the graph it is in. Raises UnknownNameError."""

    async def ask(tool: ToolNode) -> tuple[str, GraphView]:
        name = tool.graph.resolve(topic)
        await tool.snapshot_when(lambda seen: name in seen.topics(with_hidden=True))
        return name, await tool.settled_snapshot()

    name, view = await asked(graph, ask)
    if name not in view.topics(with_hidden=True):
        raise UnknownNameError(unknown_topic(name, view.topics()))
    return name, view


def format_end(end: EndpointInfo) -> str:
    """Return one endpoint as `ros2 topic info -v` prints it."""
    node = end.node_name.rpartition("/")[2]
    lines = [
        f"Node name: {node}",
        f"Node namespace: {namespace_of(end.node_name)}",
        f"Topic type: {end.type}",
        f"Topic type hash: {end.type_hash or 'INVALID'}",
        f"Endpoint type: {end.kind.value}",
        f"GID: {'.'.join(f'{byte:02x}' for byte in end.gid)}",
    ]
    qos = end.qos
    if qos is not None:
        depth = f" ({qos.depth})" if qos.history == "KEEP_LAST" else ""
        lines += [
            "QoS profile:",
            f"  Reliability: {qos.reliability}",
            f"  History (Depth): {qos.history}{depth}",
            f"  Durability: {qos.durability}",
            f"  Lifespan: {qos.lifespan}",
            f"  Deadline: {qos.deadline}",
            f"  Liveliness: {qos.liveliness}",
            f"  Liveliness lease duration: {qos.lease}",
        ]
    return "\n".join(map(escape_line, lines))


def end_record(end: EndpointInfo) -> dict[str, Any]:
    """Return one endpoint for `--json`."""
    return {
        "node": end.node_name,
        "type": end.type,
        "type_hash": end.type_hash or None,
        "gid": end.gid.hex() or None,
        "qos": asdict(end.qos) if end.qos is not None else None,
    }
