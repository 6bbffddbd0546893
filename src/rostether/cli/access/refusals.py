"""Refuses options of one ROS when the other is selected."""

from __future__ import annotations

import click


def refuse_ros1_only(**given: object) -> None:
    """Raise UsageError for an option that was given and works on ROS 1 only."""
    _refuse(given, "works on ROS 1 only; leave it out or add --ros1")


def refuse_ros2_only(**given: object) -> None:
    """Raise UsageError for an option that was given and works on ROS 2 only."""
    _refuse(given, "works on ROS 2 only; leave it out or add --ros2")


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
    """Return the error for a command that does not exist on ROS 2."""
    return click.UsageError(f"`{command}` works on ROS 1 only: {instead}")
