"""What belongs to one ROS only is refused in one line where the other is meant."""

from __future__ import annotations

import click


def refuse_ros1_only(**given: object) -> None:
    """Raise UsageError for an option that was given and means something on ROS 1 alone."""
    _refuse(given, "is of ROS 1: leave it out with --ros2, or say --ros1")


def refuse_ros2_only(**given: object) -> None:
    """Raise UsageError for an option that was given and means something on ROS 2 alone."""
    _refuse(given, "is of ROS 2: leave it out, or say --ros2")


def _refuse(given: dict[str, object], why: str) -> None:
    for name, value in given.items():
        if value:
            raise click.UsageError(f"{_spelled(name)} {why}")


def _spelled(name: str) -> str:
    context = click.get_current_context(silent=True)
    for parameter in context.command.params if context is not None else ():
        if parameter.name == name:
            return max(parameter.opts, key=len) if isinstance(parameter, click.Option) else name.upper()
    return name


def not_on_ros2(command: str, instead: str) -> click.UsageError:
    """Return the error for a command that has no meaning on ROS 2."""
    return click.UsageError(f"`{command}` is of ROS 1: {instead}")
