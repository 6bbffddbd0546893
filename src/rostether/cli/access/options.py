"""Options that several commands share, and the refusal of options of the other ROS."""

from __future__ import annotations

from collections.abc import Callable

import click

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.shell.option_group import PATH, Function, add_option, ignored_options

# Hints for users who give these options to a command that reads link addresses.
ADDRESS_HINTS = dict.fromkeys(
    ("--baud", "--baudrate", "-b"), 'write it after the port: "/dev/ttyACM0?baud=115200"'
)

msg_path_option = add_option(
    "--msg-path msg_paths DIR",
    "Search this folder for packages, .msg and .srv files before ROS_PACKAGE_PATH; may be repeated.",
    multiple=True,
    type=PATH,
)

ignored_qos_options = ignored_options(
    "--qos-profile", "--qos-depth", "--qos-history", "--qos-reliability", "--qos-liveliness"
)


def window_option(default: int | None) -> Callable[[Function], Function]:
    """Return the option `-w` of the commands that measure over a window of messages."""
    return add_option(
        "-w --window COUNT",
        f"Measure over the last COUNT messages{f' (default: {default})' if default else ''}.",
        type=click.IntRange(min=2),
        default=default,
    )


listen_option = add_option(
    "--listen ADDRESS",
    "Listen on this address for other machines; 0.0.0.0 for all addresses (default: loopback only).",
)


def refuse_ros1_only(**given: object) -> None:
    """Raise UsageError for an option of ROS 1 that was given; the keywords are parameters of the command."""
    _refuse(given, "works on ROS 1 only; omit it or add --ros1")


def refuse_ros2_only(**given: object) -> None:
    """Raise UsageError for an option of ROS 2 that was given; the keywords are parameters of the command."""
    _refuse(given, "works on ROS 2 only; omit it or add --ros2")


def _refuse(given: dict[str, object], why: str) -> None:
    for name, value in given.items():
        if value:
            raise click.UsageError(f"{_spelled(name)} {why}")


def _spelled(name: str) -> str:
    """Return how the user spells a parameter of the running command: `--host`, or `TYPE` of an argument."""
    context = click.get_current_context(silent=True)
    for parameter in context.command.params if context is not None else ():
        if parameter.name == name:
            if isinstance(parameter, click.Option):
                return max(parameter.opts, key=len)
            return parameter.human_readable_name.strip("[].")
    return name


def refuse_ros2(graph: GraphOptions, command: str, instead: str) -> None:
    """Raise UsageError for a ROS 2 graph, which does not have this command; `instead` names what to do."""
    if graph.ros2 is not None:
        raise click.UsageError(f"`{command}` works on ROS 1 only: {instead}")
