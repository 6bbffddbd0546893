"""`rostether topic list|info|type|find`: what the master knows of topics, in rostopic's words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.completions import complete_message_types, complete_topics
from rostether.cli.access.options import master_option, msg_path_option
from rostether.cli.access.refusals import refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option, one_line, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import UnknownNameError

if TYPE_CHECKING:
    from rostether.ros1.node.master_client import MasterClient

UNKNOWN_TYPE = "unknown type"
ANY_TYPE = "*"


@dataclass(frozen=True, slots=True)
class TopicView:
    """One topic as the master knows it; `type` is "unknown type" while nobody has told it."""

    name: str
    type: str
    publishers: list[str]
    subscribers: list[str]


async def fetch_topics(master: str | None) -> list[TopicView]:
    """Return all topics, sorted by name. Raises MasterUnreachableError."""
    from rostether.cli.access.ros1_access import master_client, read_environment

    async with master_client(read_environment(master)) as client:
        publishers, subscribers, _ = await client.system_state()
        types = await client.topic_types()
    return [
        TopicView(name, types.get(name, UNKNOWN_TYPE), publishers.get(name, []), subscribers.get(name, []))
        for name in sorted(publishers.keys() | subscribers.keys())
    ]


hidden_topics_option = click.option(
    "--include-hidden-topics", "with_hidden", is_flag=True, help="With --ros2, hidden topics (_name) too."
)


@click.command(
    "list",
    cls=Verb,
    examples="""
    rostether topic list
    rostether topic list -v
    rostether topic list --json
    rostether topic list -t --ros2
    """,
)
@click.argument("namespace", required=False, shell_complete=complete_topics)
@click.option("-v", "--verbose", is_flag=True, help="Show types and how many nodes publish and subscribe.")
@click.option("-p", "publishers", is_flag=True, help="Only topics that are published.")
@click.option("-s", "subscribers", is_flag=True, help="Only topics that are subscribed to.")
@click.option("--host", "by_host", is_flag=True, help="Group by machine.")
@click.option("-t", "--show-types", is_flag=True, help="Show types.")
@click.option("-c", "--count-topics", is_flag=True, help="Only print how many there are.")
@hidden_topics_option
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def list_topics(
    namespace: str | None,
    verbose: bool,
    publishers: bool,
    subscribers: bool,
    by_host: bool,
    show_types: bool,
    count_topics: bool,
    with_hidden: bool,
    as_json: bool,
    master: str | None,
) -> None:
    """List the topics, of all or of a namespace."""
    if publishers and subscribers:
        raise click.UsageError("give one of -p and -s, not both")
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.topic import ros2_listing as ros2
        from rostether.ros2.endpoint_info import EndpointKind

        refuse_ros1_only(by_host=by_host, master=master)
        wanted = EndpointKind.PUBLISHER if publishers else EndpointKind.SUBSCRIPTION if subscribers else None
        listing = ros2.Listing(namespace, verbose, show_types, count_topics, with_hidden, as_json, wanted)
        ros2.list_topics(middleware, listing)
        return
    from rostether.cli.access.ros1_access import in_namespace, read_environment, resolve

    topics = run(fetch_topics(master))
    if namespace is not None and (within := resolve(namespace, read_environment(master))) != "/":
        topics = [topic for topic in topics if in_namespace(topic.name, within)]
    if publishers or subscribers:
        topics = [topic for topic in topics if (topic.publishers if publishers else topic.subscribers)]
    if as_json:
        for topic in topics:
            write_json(
                {
                    "topic": topic.name,
                    "type": None if topic.type in (UNKNOWN_TYPE, ANY_TYPE) else topic.type,
                    "publishers": topic.publishers,
                    "subscribers": topic.subscribers,
                }
            )
    elif count_topics:
        write_line(str(len(topics)))
    elif show_types and not verbose:
        for topic in topics:
            write_line(f"{topic.name} [{topic.type}]")
    elif by_host:
        for host, found in run(_by_host(topics, master)).items():
            write_line(f"Host [{host}]:")
            _write_list(found, verbose, publishers, subscribers, "  ")
    else:
        _write_list(topics, verbose, publishers, subscribers, "")


def _write_list(
    topics: Iterable[TopicView], verbose: bool, publishers: bool, subscribers: bool, indent: str
) -> None:
    if not verbose:
        write_line("\n".join(indent + topic.name for topic in topics))
        return
    if not subscribers:
        write_line(f"\n{indent}Published topics:")
        for topic in topics:
            _write_count(topic, len(topic.publishers), "publisher", indent)
    if not publishers:
        write_line(f"{indent}\n{indent}Subscribed topics:")
        for topic in topics:
            _write_count(topic, len(topic.subscribers), "subscriber", indent)
    write_line()


def _write_count(topic: TopicView, count: int, what: str, indent: str) -> None:
    if count:
        write_line(f"{indent} * {topic.name} [{topic.type}] {count} {what}{'s' if count > 1 else ''}")


async def _by_host(topics: list[TopicView], master: str | None) -> dict[str, list[TopicView]]:
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.ros1.environment import parse_rpc_uri

    async with master_client(read_environment(master)) as client:
        uris = await _node_uris(
            client, {node for topic in topics for node in [*topic.publishers, *topic.subscribers]}
        )
    hosts = {node: parse_rpc_uri(uri).host for node, uri in uris.items() if uri is not None}
    grouped: dict[str, list[TopicView]] = {}
    for host in sorted(set(hosts.values())):
        for topic in topics:
            publishers = [node for node in topic.publishers if hosts.get(node) == host]
            subscribers = [node for node in topic.subscribers if hosts.get(node) == host]
            if publishers or subscribers:
                view = TopicView(topic.name, topic.type, publishers, subscribers)
                grouped.setdefault(host, []).append(view)
    return grouped


@click.command(
    "info", cls=Verb, examples="rostether topic info /ultrasound\nrostether topic info -v --ros2 /ultrasound"
)
@click.argument("topic", shell_complete=complete_topics)
@click.option("-v", "--verbose", is_flag=True, help="With --ros2, show each end and its quality of service.")
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def info(topic: str, verbose: bool, as_json: bool, master: str | None) -> None:
    """Show a topic's type, and the nodes that publish and subscribe to it."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.topic import ros2_listing as ros2

        refuse_ros1_only(master=master)
        ros2.info(middleware, topic, verbose=verbose, as_json=as_json)
        return
    refuse_ros2_only(verbose=verbose)
    view, uris = run(_fetch_one(topic, master))
    if as_json:
        write_json(
            {
                "topic": view.name,
                "type": None if view.type in (UNKNOWN_TYPE, ANY_TYPE) else view.type,
                "publishers": [{"node": node, "uri": uris[node]} for node in view.publishers],
                "subscribers": [{"node": node, "uri": uris[node]} for node in view.subscribers],
            }
        )
        return
    write_line(f"Type: {view.type}\n")
    for title, nodes in (("Publishers", view.publishers), ("Subscribers", view.subscribers)):
        write_line(f"{title}: " if nodes else f"{title}: None")
        for node in nodes:
            write_line(one_line(f" * {node} ({uris[node] or f'unknown address {node}'})"))
        write_line()
    # rostopic ends with one line more.
    write_line()


async def _fetch_one(topic: str, master: str | None) -> tuple[TopicView, dict[str, str | None]]:
    from rostether.cli.access.ros1_access import master_client, read_environment, resolve

    environment = read_environment(master)
    name = resolve(topic, environment)
    for view in await fetch_topics(master):
        if view.name == name:
            async with master_client(environment) as client:
                return view, await _node_uris(client, {*view.publishers, *view.subscribers})
    raise unknown_topic(name)


async def _node_uris(client: MasterClient, nodes: Iterable[str]) -> dict[str, str | None]:
    """Return each node's URI, None for one that has left meanwhile."""
    uris: dict[str, str | None] = {}
    for node in nodes:
        try:
            uris[node] = await client.lookup_node(node)
        except UnknownNameError:
            uris[node] = None
    return uris


def unknown_topic(name: str) -> UnknownNameError:
    """Return the error for a topic that nobody publishes or subscribes to."""
    return UnknownNameError(
        f"nobody publishes or subscribes to {name}; `rostether topic list` shows what there is"
    )


@click.command(
    "type",
    cls=Verb,
    examples="""
    rostether topic type /ultrasound
    rostether topic type /ultrasound/header/stamp
    rostether topic type /ultrasound | rostether msg show
    """,
)
@click.argument("topic", metavar="TOPIC[/FIELD]", shell_complete=complete_topics)
@msg_path_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def type_of(topic: str, msg_paths: tuple[Path, ...], master: str | None) -> None:
    """Print the type of a topic, or of a field: then the topic's type, the field, and the field's type."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.topic import ros2_listing as ros2

        refuse_ros1_only(master=master)
        ros2.type_of(middleware, topic)
        return
    from rostether.cli.access.ros1_access import read_environment
    from rostether.cli.topic.chosen_topic import choose_topic, resolve_with_field
    from rostether.msgdef.registry import Registry
    from rostether.serde.field_path import FieldPath
    from rostether.serde.store import TypeStore

    name = resolve_with_field(topic, read_environment(master))
    store = TypeStore(Registry.from_environment(msg_paths))
    chosen = choose_topic(name, run(fetch_topics(master)), store)
    if chosen is None:
        raise unknown_topic(name)
    if not chosen.field:
        write_line(chosen.type)
    else:
        field_type = FieldPath(store.codec(chosen.type), chosen.field).type
        write_line(f"{chosen.type} {chosen.field} {field_type}")


@click.command("find", cls=Verb, examples="rostether topic find sensor_msgs/Range")
@click.argument("type_name", metavar="TYPE", shell_complete=complete_message_types)
@hidden_topics_option
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def find(type_name: str, with_hidden: bool, as_json: bool, master: str | None) -> None:
    """List the topics of a type."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.topic import ros2_listing as ros2

        refuse_ros1_only(master=master)
        ros2.find(middleware, type_name, as_json=as_json, with_hidden=with_hidden)
        return
    for topic in run(fetch_topics(master)):
        if topic.type == type_name:
            if as_json:
                write_json({"topic": topic.name})
            else:
                write_line(topic.name)
