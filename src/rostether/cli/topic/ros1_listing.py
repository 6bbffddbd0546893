"""`topic list|info|type|find` on a ROS 1 graph, with rostopic's output."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros2_only
from rostether.cli.access.ros1_access import master_client, read_environment, resolve, type_store
from rostether.cli.shell.output import write_json, write_line, write_result
from rostether.cli.shell.own_command import called_as
from rostether.cli.topic.options import TopicListing
from rostether.cli.topic.ros1_chosen_topic import (
    choose_topic,
    fetch_topics,
    known_type,
    node_uris,
    resolve_with_field,
)
from rostether.errors import UnknownNameError
from rostether.graph.ports import TopicEntry
from rostether.mechanisms.text import counted, escape_line, unknown_topic
from rostether.names.graph_name import is_in_namespace
from rostether.ros1.environment import RosEnvironment, parse_rpc_uri


class Ros1TopicListing:
    """The part of `Ros1Topics` that receives and sends no messages."""

    def __init__(self, graph: GraphOptions) -> None:
        self._graph = graph
        self._environment = read_environment(graph)

    async def list_topics(self, wanted: TopicListing) -> None:
        """Print the topics."""
        environment = self._environment
        topics = await fetch_topics(environment)
        if wanted.namespace is not None and (within := resolve(wanted.namespace, environment)) != "/":
            topics = [topic for topic in topics if is_in_namespace(topic.name, within)]
        if wanted.publishers:
            topics = [topic for topic in topics if topic.publishers]
        if wanted.subscribers:
            topics = [topic for topic in topics if topic.subscribers]
        if wanted.as_json:
            for topic in topics:
                write_json(
                    {
                        "topic": topic.name,
                        "type": known_type(topic),
                        "publishers": topic.publishers,
                        "subscribers": topic.subscribers,
                    }
                )
        elif wanted.count_topics:
            write_line(str(len(topics)))
        elif wanted.show_types and not wanted.verbose:
            for topic in topics:
                write_line(f"{topic.name} [{_shown_type(topic)}]")
        elif wanted.by_host:
            for host, found in (await _by_host(topics, environment)).items():
                write_line(f"Host [{host}]:")
                _write_list(found, wanted, "  ")
        else:
            _write_list(topics, wanted, "")

    async def info(self, topic: str, *, verbose: bool, as_json: bool) -> None:
        """Print a topic's type, and the nodes that publish and subscribe to it. Raises UnknownNameError."""
        refuse_ros2_only(verbose=verbose)
        name, topics = resolve(topic, self._environment), await fetch_topics(self._environment)
        view = next((each for each in topics if each.name == name), None)
        if view is None:
            raise UnknownNameError(unknown_topic(name, (each.name for each in topics)))
        async with master_client(self._environment) as client:
            uris = await node_uris(client, {*view.publishers, *view.subscribers})
        if as_json:
            write_json(
                {
                    "topic": view.name,
                    "type": known_type(view),
                    "publishers": [{"node": node, "uri": uris[node]} for node in view.publishers],
                    "subscribers": [{"node": node, "uri": uris[node]} for node in view.subscribers],
                }
            )
            return
        write_line(f"Type: {_shown_type(view)}\n")
        for title, nodes in (("Publishers", view.publishers), ("Subscribers", view.subscribers)):
            write_line(f"{title}: " if nodes else f"{title}: None")
            for node in nodes:
                write_line(escape_line(f" * {node} ({uris[node] or f'unknown address {node}'})"))
            write_line()
        # As in rostopic, the output ends with two empty lines.
        write_line()

    async def type_of(self, topic: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the type of a topic, or of a field in it. Raises UnknownNameError."""
        from rostether.msgdef.search_waiting import wait_for_definitions
        from rostether.serde.field_path import FieldPath

        name = resolve_with_field(topic, self._environment)
        store = type_store(msg_paths)
        views = await fetch_topics(self._environment)
        chosen = await wait_for_definitions(store.registry, lambda: choose_topic(name, views, store))
        if chosen is None:
            raise UnknownNameError(unknown_topic(name, (view.name for view in views)))
        if not chosen.field:
            write_line(chosen.type)
        else:
            field_type = FieldPath(store.codec(chosen.type), chosen.field).type
            write_line(f"{chosen.type} {chosen.field} {field_type}")

    async def find(self, type_name: str, *, with_hidden: bool, as_json: bool) -> None:
        """Print the topics of a type."""
        topics = await fetch_topics(self._environment)
        found = [topic.name for topic in topics if topic.type == type_name]
        for name in found:
            write_result({"topic": name}, name, as_json=as_json)
        # rostopic writes an empty line.
        if not found and called_as() == "rostopic":
            write_line()


def _shown_type(topic: TopicEntry) -> str:
    return known_type(topic) or "unknown type"


def _write_list(topics: Iterable[TopicEntry], wanted: TopicListing, indent: str) -> None:
    if not wanted.verbose:
        write_line("\n".join(indent + topic.name for topic in topics))
        return
    if not wanted.subscribers:
        write_line(f"\n{indent}Published topics:")
        for topic in topics:
            _write_count(topic, len(topic.publishers), "publisher", indent)
    if not wanted.publishers:
        write_line(f"{indent}\n{indent}Subscribed topics:")
        for topic in topics:
            _write_count(topic, len(topic.subscribers), "subscriber", indent)
    write_line()


def _write_count(topic: TopicEntry, count: int, what: str, indent: str) -> None:
    if count:
        write_line(f"{indent} * {topic.name} [{_shown_type(topic)}] {counted(count, what)}")


async def _by_host(topics: list[TopicEntry], environment: RosEnvironment) -> dict[str, list[TopicEntry]]:
    async with master_client(environment) as client:
        uris = await node_uris(
            client, {node for topic in topics for node in [*topic.publishers, *topic.subscribers]}
        )
    hosts = {node: parse_rpc_uri(uri).host for node, uri in uris.items() if uri is not None}
    grouped: dict[str, list[TopicEntry]] = {}
    for host in sorted(set(hosts.values())):
        for topic in topics:
            publishers = tuple(node for node in topic.publishers if hosts.get(node) == host)
            subscribers = tuple(node for node in topic.subscribers if hosts.get(node) == host)
            if publishers or subscribers:
                found = TopicEntry(topic.name, topic.type, publishers, subscribers)
                grouped.setdefault(host, []).append(found)
    return grouped
