"""`rostether topic list|info|type|find`: lists and describes topics."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.access.completions import complete_message_types, complete_topics
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.option_group import add_flag, option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import verb
from rostether.cli.topic.options import TopicListing, hidden_topics_option
from rostether.cli.topic.topics import topics_of


@verb(
    "list",
    """
    rostether topic list
    rostether topic list -v
    rostether topic list --json
    rostether topic list -t --ros2
    """,
)
@option_group("wanted", TopicListing)
@graph_options()
def list_topics(wanted: TopicListing, graph: GraphOptions) -> None:
    """List all topics, or those in a namespace."""
    if wanted.publishers and wanted.subscribers:
        raise click.UsageError("give one of -p and -s, not both")
    if wanted.bag is not None:
        from rostether.cli.topic.recorded_echo import list_recording

        list_recording(wanted.bag)
        return
    topics_of(graph).list_topics(wanted)


@verb("info", "rostether topic info /ultrasound\nrostether topic info -v --ros2 /ultrasound")
@click.argument("topic", shell_complete=complete_topics)
@add_flag("-v --verbose", "With --ros2, show each endpoint and its quality of service.")
@json_option
@graph_options()
def info(topic: str, verbose: bool, as_json: bool, graph: GraphOptions) -> None:
    """Show a topic's type, and the nodes that publish and subscribe to it."""
    topics_of(graph).info(topic, verbose=verbose, as_json=as_json)


@verb(
    "type",
    """
    rostether topic type /ultrasound
    rostether topic type /ultrasound/header/stamp
    rostether topic type /ultrasound | rostether msg show
    """,
)
@click.argument("topic", metavar="TOPIC[/FIELD]", shell_complete=complete_topics)
@msg_path_option
@graph_options()
def type_of(topic: str, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
    """Print the type of a topic; for a field, print the topic's type, the field, and the field's type."""
    topics_of(graph).type_of(topic, msg_paths)


@verb("find", "rostether topic find sensor_msgs/Range")
@click.argument("type_name", metavar="TYPE", shell_complete=complete_message_types)
@hidden_topics_option
@json_option
@graph_options()
def find(type_name: str, with_hidden: bool, as_json: bool, graph: GraphOptions) -> None:
    """List the topics of a type."""
    topics_of(graph).find(type_name, with_hidden=with_hidden, as_json=as_json)
