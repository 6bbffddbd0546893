"""`rostether topic`: the table of its verbs."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "list": VerbEntry("rostether.cli.topic.listing:list_topics", "List the topics."),
    "info": VerbEntry("rostether.cli.topic.listing:info", "Show a topic's type, publishers and subscribers."),
    "type": VerbEntry("rostether.cli.topic.listing:type_of", "Print the type of a topic or of a field."),
    "echo": VerbEntry("rostether.cli.topic.echo:echo", "Print the messages of a topic."),
    "pub": VerbEntry("rostether.cli.topic.pub:pub", "Publish messages."),
    "hz": VerbEntry("rostether.cli.topic.rates:hz", "Measure the message rate."),
    "bw": VerbEntry("rostether.cli.topic.rates:bw", "Measure the bandwidth of a topic."),
    "delay": VerbEntry("rostether.cli.topic.rates:delay", "Measure the age of messages on arrival."),
    "find": VerbEntry("rostether.cli.topic.listing:find", "List the topics of a type."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether topic list
    rostether topic echo /ultrasound
    rostether topic pub -1 /toggle_led std_msgs/Empty
    rostether topic hz /imu_data
    """,
)
def topic() -> None:
    """List, show, publish and measure the topics of a ROS graph."""
