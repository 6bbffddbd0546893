"""`rostether param describe`: what a ROS 2 node says of its parameters."""

from __future__ import annotations

import click

from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import Verb


@click.command("describe", cls=Verb, examples="rostether param describe --ros2 /board gain")
@click.argument("node")
@click.argument("names", metavar="NAME...", nargs=-1, required=True)
@json_option
@ros1_option
@ros2_option
@daemon_habits
def describe(node: str, names: tuple[str, ...], as_json: bool) -> None:
    """Show the type, the limits and the description of a ROS 2 node's parameters."""
    if (middleware := chosen_ros2()) is None:
        raise click.UsageError(
            "parameters of ROS 1 have no description: say --ros2 for those of a ROS 2 node"
        )
    from rostether.cli.param import ros2_param as ros2

    ros2.describe(middleware, node, names, as_json=as_json)
