"""`rostether topic echo`: a topic's messages, or one field of them."""

from __future__ import annotations

import click

from rostether.cli.access.completions import complete_fields
from rostether.cli.access.graph_options import TOOL_ALLOW, GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option, qos_habits
from rostether.cli.shell.option_group import ignored_options, option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import Verb
from rostether.cli.topic.topics import EchoOptions, topics_of

_echo_options = option_group(
    "options",
    EchoOptions,
    (
        click.option(
            "-n", "--count", type=click.IntRange(min=1), metavar="COUNT", help="Stop after COUNT messages."
        ),
        click.option("--once", is_flag=True, help="Stop after one message."),
        click.option("-p", "plot", is_flag=True, help="Print comma-separated values, for plotting."),
        json_option,
        click.option("-c", "--clear", is_flag=True, help="Clear the screen before each message."),
        click.option("--noarr", "--no-arr", is_flag=True, help="Leave arrays out."),
        click.option("--nostr", "--no-str", is_flag=True, help="Leave strings out."),
        click.option(
            "-w",
            "number_width",
            type=click.IntRange(min=2),
            metavar="WIDTH",
            help="Width of a number in columns.",
        ),
        click.option("--offset", is_flag=True, help="Print times relative to now, in seconds."),
        click.option(
            "--filter",
            "expression",
            metavar="EXPRESSION",
            help="Print only messages m for which the Python expression is true.",
        ),
        click.option(
            "--field",
            default="",
            metavar="FIELD",
            help="With --ros2, print only this field, e.g. header.stamp.",
        ),
        click.option("--csv", is_flag=True, help="With --ros2, print comma-separated values."),
        click.option(
            "-f", "--full-length", is_flag=True, help="With --ros2, do not truncate arrays and strings."
        ),
        click.option(
            "-l",
            "--truncate-length",
            type=click.IntRange(min=0),
            metavar="LENGTH",
            help="With --ros2, truncate arrays and strings to LENGTH (128).",
        ),
        click.option("--flow-style", is_flag=True, help="With --ros2, print each message on one line."),
        click.option(
            "--timeout",
            "timeout_s",
            type=click.FloatRange(min=0, min_open=True),
            metavar="SECONDS",
            help="With --ros2, give up after SECONDS.",
        ),
        msg_path_option,
    ),
)


@click.command(
    "echo",
    cls=Verb,
    examples="""
    rostether topic echo /ultrasound
    rostether topic echo -n 1 /ultrasound/range
    rostether topic echo --filter "m.range < 0.5" /ultrasound
    rostether topic echo -p /imu_data/angular_velocity > turning.csv
    """,
)
@click.argument("topic", metavar="TOPIC[/FIELD]", shell_complete=complete_fields)
@click.argument("type_name", metavar="[TYPE]", required=False)
@_echo_options
@graph_options(allow=TOOL_ALLOW)
@ignored_options("--qos-durability")
@qos_habits
def echo(topic: str, type_name: str | None, options: EchoOptions, graph: GraphOptions) -> None:
    """Print the messages of a topic, or a field of them.

    Message types come from the publisher, so types that are not installed also work. The command waits for a
    topic that does not exist yet, unless you give its TYPE.
    """
    topics_of(graph).echo(topic, type_name, options)
