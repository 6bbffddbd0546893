"""`rostether topic pub`: publishes messages from the command line, a file or a pipe."""

from __future__ import annotations

import re

import click

from rostether.cli.access.completions import complete_topic_type, complete_topics
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import ignored_qos_options
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.verbs import Verb, verb
from rostether.cli.topic.options import PubOptions
from rostether.cli.topic.topics import topics_of

# Negative numbers, except -1: this is the option that publishes once.
_NEGATIVE = re.compile(r"-(?!1$)(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


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
) -> None:
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
    topics_of(graph).publish(topic, type_name, values, options)
