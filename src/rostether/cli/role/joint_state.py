"""The built-in joint_state_publisher and joint_state_publisher_gui, with sliders in the terminal."""

from __future__ import annotations

import asyncio
import sys

import click

from rostether.cli.role.node import NODE_SETTINGS, node_arguments, role_node
from rostether.cli.shell.output import warn
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.names.remap import Arguments

_arguments = click.argument("words", nargs=-1, type=click.UNPROCESSED, metavar="[NAME:=VALUE...]")

GUI_NAME = "joint_state_publisher_gui"

NO_TERMINAL = (
    "no terminal for the sliders: they are in the dashboard, at Controls; or run in a terminal: "
    "rostether run joint_state_publisher_gui joint_state_publisher_gui __name:={}"
)


@click.command(
    "joint-state-publisher",
    cls=Verb,
    context_settings=NODE_SETTINGS,
    examples="rostether role joint-state-publisher _rate:=50 _source_list:=[arm/joint_states]",
)
@_arguments
def joint_state_publisher(words: tuple[str, ...]) -> None:
    """Publish joint states: default positions, positions from other topics, and joints that mimic others.

    Parameters: rate (10), source_list, zeros, dependent_joints, delta, use_mimic_tags,
    use_smallest_joint_limits, publish_default_positions, publish_default_velocities, publish_default_efforts.
    """
    run(_publish(node_arguments(words), "joint_state_publisher", has_sliders=False), is_service=True)


@click.command(
    "joint-state-publisher-gui",
    cls=Verb,
    context_settings=NODE_SETTINGS,
    examples="rostether role joint-state-publisher-gui",
)
@_arguments
def joint_state_publisher_gui(words: tuple[str, ...]) -> None:
    """Publish joint states set by sliders in the terminal: arrow keys move them, c centers, r randomizes."""
    # Windows has consoles, but no termios to read single keys.
    has_terminal = sys.platform != "win32" and sys.stdin.isatty() and sys.stdout.isatty()
    arguments = node_arguments(words)
    if not has_terminal:
        warn(NO_TERMINAL.format(arguments.special.get("__name", GUI_NAME)))
    run(_publish(arguments, GUI_NAME, has_sliders=has_terminal), is_service=True)


async def _publish(arguments: Arguments, node_name: str, *, has_sliders: bool) -> None:
    from rostether.robot.joint_state_publisher import SLIDERS_TOPIC, publish_joint_states, read_joint_states

    async with role_node(arguments, node_name) as graph:
        states = await read_joint_states(graph)
        if not has_sliders:
            sliders = [SLIDERS_TOPIC] if node_name == GUI_NAME else []
            await publish_joint_states(graph, states, more_sources=sliders)
            return
        from rostether.cli.role.slider_screen import SliderScreen

        screen = SliderScreen(states)
        publishing = asyncio.create_task(publish_joint_states(graph, states, screen.refresh))
        sliding = asyncio.create_task(screen.run())
        try:
            done, _ = await asyncio.wait({publishing, sliding}, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in (publishing, sliding):
                task.cancel()
            await asyncio.gather(publishing, sliding, return_exceptions=True)
