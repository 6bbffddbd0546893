"""`rostether topic echo`: a topic's messages, or one field of them."""

from __future__ import annotations

import click

from rostether.cli.access.completions import complete_fields
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import ignored_qos_options
from rostether.cli.shell.option_group import ignored_options, option_group
from rostether.cli.shell.verbs import verb
from rostether.cli.topic.options import EchoOptions
from rostether.cli.topic.topics import topics_of


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
def echo(topic: str | None, type_name: str | None, options: EchoOptions, graph: GraphOptions) -> None:
    """Print the messages of a topic, or a field of them.

    Message types come from the publisher, so types that are not installed also work. The command waits for a
    topic that does not exist yet, unless you give its TYPE.
    """
    if options.all_topics and (options.bag is None or topic is not None):
        raise click.UsageError("-a prints all topics of a recording; write: -b FILE -a, without a topic")
    if topic is None and not options.all_topics:
        raise click.UsageError("Missing argument 'TOPIC[/FIELD]'; see `rostether topic echo --help`")
    if options.bag is not None:
        from rostether.cli.topic.recorded_echo import echo_recording

        echo_recording(options.bag, topic, options)
        return
    topics_of(graph).echo(topic or "", type_name, options)
