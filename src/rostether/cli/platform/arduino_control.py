"""arduino_control as a role."""

from __future__ import annotations

import click

from rostether.cli.access.graph_options import ROS2_CHOICE
from rostether.cli.platform.parameters import Parameters, reporter
from rostether.cli.role.node import NODE_SETTINGS, run_role
from rostether.cli.shell.verbs import Verb
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments


@click.command(
    "arduino-control",
    cls=Verb,
    context_settings=NODE_SETTINGS,
    examples="""
    rostether role arduino-control
    rostether role arduino-control _formula:=radial _deadzone:=0.15 joy:=/robot_3/joy
    """,
)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[NAME:=VALUE]...")
@ROS2_CHOICE
def arduino_control(arguments: tuple[str, ...], ros2: str | None) -> None:
    """Turn a joystick's axes (`joy`) into commands for a robot (`arduino_control`).

    Parameters: ~deadzone (0.1), ~formula (reference). With ~formula radial, the speed grows smoothly from the
    edge of the dead zone to at most 1 in every direction; with reference, it reaches 1.414 in the corners.
    """
    run_role("arduino_control", arguments, _main, ros2)


async def _main(graph: TypedGraph, _: Arguments) -> None:
    from rostether.platform.arduino_control import StickSettings, publish_commands
    from rostether.platform.stick import DEFAULT_DEADZONE

    parameters = Parameters(graph, "arduino_control")
    settings = StickSettings(
        await parameters.number(DEFAULT_DEADZONE, "deadzone"), await parameters.text("reference", "formula")
    )
    await publish_commands(graph, settings, reporter(graph))
