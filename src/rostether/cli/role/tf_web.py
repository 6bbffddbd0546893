"""The built-in node tf2_web_republisher."""

from __future__ import annotations

import click

from rostether.cli.role.node import NODE_SETTINGS, node_arguments, role_node
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.names.remap import Arguments


@click.command(
    "tf2-web-republisher",
    cls=Verb,
    context_settings=NODE_SETTINGS,
    examples="rostether role tf2-web-republisher",
)
@click.argument("words", nargs=-1, type=click.UNPROCESSED, metavar="[NAME:=VALUE...]")
def tf2_web_republisher(words: tuple[str, ...]) -> None:
    """Send web pages the transforms they ask for, like tf2_web_republisher.

    It serves the service republish_tfs and the action tf2_web_republisher, which ROSLIB.TFClient uses.
    """
    run(_serve(node_arguments(words)), is_service=True)


async def _serve(arguments: Arguments) -> None:
    from rostether.robot.tf_web_republisher import NODE_NAME, report_to, republish_for_web

    async with role_node(arguments, NODE_NAME) as graph:
        await republish_for_web(graph, report_to(graph))
