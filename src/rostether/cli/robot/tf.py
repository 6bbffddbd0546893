"""`rostether tf`: the table of its verbs."""

from __future__ import annotations

import click

from rostether.cli.shell.verbs import LazyGroup, VerbEntry

_VERBS = {
    "echo": VerbEntry("rostether.cli.robot.tf_echo:echo", "Print the transform between two frames."),
    "tree": VerbEntry("rostether.cli.robot.tf_tree:tree", "Show the tree of frames."),
    "monitor": VerbEntry("rostether.cli.robot.tf_monitor:monitor", "Show the delay and rate of transforms."),
    "static": VerbEntry("rostether.cli.robot.tf_static:static", "Publish a static transform."),
}


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether tf tree
    rostether tf echo base_link gripper
    rostether tf static 0 0 0.1 0 0 0 base_link laser
    """,
)
def tf() -> None:
    """Show and publish the transforms between the frames of a robot."""
