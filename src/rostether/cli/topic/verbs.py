"""`rostether topic list|info|type|find|echo|pub`: the topics of a ROS 1 or ROS 2 graph."""

from __future__ import annotations

import re
from collections.abc import Coroutine
from pathlib import Path
from typing import Any, Protocol

import click

from rostether.cli.access.completions import (
    complete_fields,
    complete_message_types,
    complete_topic_type,
    complete_topics,
)
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import ignored_qos_options, msg_path_option
from rostether.cli.shell.option_group import add_flag, ignored_options, option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import Verb, verb
from rostether.cli.topic.options import EchoOptions, PubOptions, TopicListing, hidden_topics_option

# Negative numbers, except -1: this is the option that publishes once.
_NEGATIVE = re.compile(r"-(?!1$)(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


class Topics(Protocol):
    """The topics of one graph. Each method is a whole command; it raises RostetherError or UsageError."""

    async def list_topics(self, wanted: TopicListing) -> None:
        """Print the topics."""

    async def info(self, topic: str, *, verbose: bool, as_json: bool) -> None:
        """Print a topic's type, publishers and subscribers."""

    async def type_of(self, topic: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the type of a topic, or of a field in it."""

    async def find(self, type_name: str, *, with_hidden: bool, as_json: bool) -> None:
        """Print the topics of a type."""

    async def echo(self, topic: str, type_name: str | None, options: EchoOptions) -> None:
        """Print messages as they arrive."""

    async def publish(
        self, topic: str, type_name: str, values: tuple[str, ...], file_text: str | None, options: PubOptions
    ) -> None:
        """Publish messages."""


def topics_of(graph: GraphOptions) -> Topics:
    """Return the topics of the graph that the command line selects."""
    if graph.ros2 is None:
        from rostether.cli.topic.ros1_topics import Ros1Topics

        return Ros1Topics(graph)
    from rostether.cli.topic.ros2_topics import Ros2Topics

    return Ros2Topics(graph)


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
def list_topics(wanted: TopicListing, graph: GraphOptions) -> Coroutine[Any, Any, None] | None:
    """List all topics, or those in a namespace."""
    if wanted.publishers and wanted.subscribers:
        raise click.UsageError("give one of -p and -s, not both")
    if wanted.bag is not None:
        from rostether.cli.topic.ros1_echo import list_recording

        list_recording(wanted.bag)
        return None
    return topics_of(graph).list_topics(wanted)


@verb("info", "rostether topic info /ultrasound\nrostether topic info -v --ros2 /ultrasound")
@click.argument("topic", shell_complete=complete_topics)
@add_flag("-v --verbose", "With --ros2, show each endpoint and its quality of service.")
@json_option
@graph_options()
async def info(topic: str, verbose: bool, as_json: bool, graph: GraphOptions) -> None:
    """Show a topic's type, and the nodes that publish and subscribe to it."""
    await topics_of(graph).info(topic, verbose=verbose, as_json=as_json)


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
async def type_of(topic: str, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
    """Print the type of a topic; for a field, print the topic's type, the field, and the field's type."""
    await topics_of(graph).type_of(topic, msg_paths)


@verb("find", "rostether topic find sensor_msgs/Range")
@click.argument("type_name", metavar="TYPE", shell_complete=complete_message_types)
@hidden_topics_option
@json_option
@graph_options()
async def find(type_name: str, with_hidden: bool, as_json: bool, graph: GraphOptions) -> None:
    """List the topics of a type."""
    await topics_of(graph).find(type_name, with_hidden=with_hidden, as_json=as_json)


@verb(
    "echo",
    """
    rostether topic echo /ultrasound
    rostether topic echo -n 1 /ultrasound/range
    rostether topic echo --filter "m.range < 0.5" /ultrasound
    rostether topic echo -p /imu_data/angular_velocity > turning.csv
    rostether topic echo -b drive.bag -p /ultrasound > ranges.csv
    """,
)
@click.argument("topic", metavar="TOPIC[/FIELD]", required=False, shell_complete=complete_fields)
@click.argument("type_name", metavar="[TYPE]", required=False)
@option_group("options", EchoOptions)
@graph_options(allow=True)
@ignored_options("--qos-durability")
@ignored_qos_options
def echo(
    topic: str | None, type_name: str | None, options: EchoOptions, graph: GraphOptions
) -> Coroutine[Any, Any, None] | None:
    """Print the messages of a topic, or a field of them.

    Message types come from the publisher, so types that are not installed also work. The command waits for a
    topic that does not exist yet, unless you give its TYPE.
    """
    if options.all_topics and (options.bag is None or topic is not None):
        raise click.UsageError("-a prints all topics of a recording; write: -b FILE -a, without a topic")
    if topic is None and not options.all_topics:
        raise click.UsageError("Missing argument 'TOPIC[/FIELD]'; see `rostether topic echo --help`")
    if options.bag is not None:
        from rostether.cli.topic.ros1_echo import echo_recording

        # Outside the event loop, Ctrl-C ends this immediately.
        echo_recording(options.bag, topic, options)
        return None
    return topics_of(graph).echo(topic or "", type_name, options)


class _Pub(Verb):
    """Reads negative numbers as values, not as options, until `--`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        end = args.index("--") if "--" in args else len(args)
        first = next((index for index, each in enumerate(args[:end]) if _NEGATIVE.fullmatch(each)), None)
        # A number follows the topic and the type; before them it would be the value of an option.
        if first is not None and sum(not each.startswith("-") for each in args[:first]) >= 2:
            flags = [each for each in args[first:end] if each in self._flags(ctx)]
            values = [each for each in args[first:end] if each not in flags]
            args = [*args[:first], *flags, "--", *values, *args[end + 1 :]]
        return super().parse_args(ctx, args)

    def _flags(self, ctx: click.Context) -> set[str]:
        return {
            word
            for each in self.get_params(ctx)
            if isinstance(each, click.Option) and each.is_flag
            for word in each.opts
        }


@verb(
    "pub",
    """
    rostether topic pub -1 /toggle_led std_msgs/Empty
    rostether topic pub -r 10 /cmd_vel geometry_msgs/Twist "{linear: {x: 0.2}}"
    rostether topic pub -1 /servo std_msgs/UInt16 90
    rostether topic pub -r 1 -s /a geometry_msgs/PointStamped "{header: auto}"
    """,
    cls=_Pub,
)
@click.argument("topic", shell_complete=complete_topics)
@click.argument("type_name", metavar="TYPE", shell_complete=complete_topic_type)
@click.argument("values", nargs=-1, metavar="[VALUES]...")
@option_group("options", PubOptions)
@graph_options(allow=True)
@ignored_qos_options
def pub(
    topic: str, type_name: str, values: tuple[str, ...], options: PubOptions, graph: GraphOptions
) -> Coroutine[Any, Any, None]:
    """Publish messages.

    VALUES are YAML: a mapping of fields, where missing fields are zero, or the values of all fields in order.
    Write -- before the number -1. `now` becomes the current time, and `auto` a header with the current time.
    Without -1 and -r, the message is latched until Ctrl-C. Without VALUES, messages come from a file (-f) or
    a pipe, as YAML documents separated by ---.

    With --ros2, the command works like `ros2 topic pub`: without -1 and -t it publishes repeatedly, once a
    second unless -r is given, and missing fields have their defaults.
    """
    if values and options.file is not None:
        raise click.UsageError("give values or a file, not both")
    from rostether.cli.shell.input import read_text

    # Outside the event loop, Ctrl-C immediately ends a read from a terminal.
    text = None if options.file is None else read_text(options.file)
    return topics_of(graph).publish(topic, type_name, values, text, options)
