"""The built-in node robot_state_publisher."""

from __future__ import annotations

import click

from rostether.cli.role.node import NODE_SETTINGS, node_arguments, role_node
from rostether.cli.shell.output import warn
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.graph.ports import Level
from rostether.names.remap import Arguments

NODE_NAME = "robot_state_publisher"


@click.command(
    "robot-state-publisher",
    cls=Verb,
    context_settings=NODE_SETTINGS,
    examples="rostether role robot-state-publisher _publish_frequency:=30 joint_states:=arm/joint_states",
)
@click.argument("words", nargs=-1, type=click.UNPROCESSED, metavar="[NAME:=VALUE...]")
def robot_state_publisher(words: tuple[str, ...]) -> None:
    """Turn joint states into transforms, using the URDF in robot_description.

    Parameters: ~publish_frequency (50), ~use_tf_static (true), ~ignore_timestamp (false), tf_prefix.
    """
    run(_publish(node_arguments(words)), is_service=True)


async def _publish(arguments: Arguments) -> None:
    from rostether.robot.robot_state_publisher import publish_robot_state

    async with role_node(arguments, NODE_NAME) as graph:

        def report(problem: str) -> None:
            graph.log(Level.WARN, problem)
            warn(f"[WARN] {problem}")

        await publish_robot_state(graph, report)
