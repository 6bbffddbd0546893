"""Reads a robot.toml, and checks the commands of its parts without running them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.shell.failures import usage_text
from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.platform.boot.robot_file import RobotFile

# Commands that would start `up` again, or change what starts at boot.
_NOT_PARTS = ("up", "install", "uninstall")


def read_robot(path: Path) -> RobotFile:
    """Return the content of a robot.toml, without checking the arguments of its parts. Raises ConfigError."""
    from rostether.mechanisms.toml_text import read_toml_text

    return parse_robot(read_toml_text(path), str(path))


def parse_robot(text: str, file: str) -> RobotFile:
    """Return what the text of a robot.toml contains; `file` is the name in errors. Raises ConfigError."""
    from rostether.cli.verb_table import VERBS
    from rostether.platform.boot.robot_file import parse_robot_file

    return parse_robot_file(text, file, VERBS.keys() - set(_NOT_PARTS))


def check_robot(robot: RobotFile, file: str) -> None:
    """Raise ConfigError for an address, or for arguments of a part, that cannot be used."""
    from rostether.ros1.environment import RosEnvironment

    try:
        RosEnvironment.read(robot.environment)
    except ConfigError as error:
        raise ConfigError(f"{file}: {error}") from None
    for part in robot.parts:
        try:
            _check_command(part.words)
        except (ConfigError, click.UsageError) as error:
            reason = usage_text(error) if isinstance(error, click.UsageError) else error
            raise ConfigError(f"{file}: parts.{part.name}: {reason}") from None


def _check_command(words: Sequence[str]) -> None:
    """Parse a command line. Raises ConfigError, click.UsageError."""
    from rostether.cli.main import rostether, split_special

    rest, specials = split_special(words)
    command: click.Command | None = rostether
    context = click.Context(rostether, info_name="rostether", obj=specials)
    name: str | None = None
    try:
        while isinstance(command, click.Group):
            if not rest:
                raise ConfigError(f"give a command after {name}")
            name, command, rest = command.resolve_command(context, rest)
            if command is not None and isinstance(command, click.Group):
                context = click.Context(command, info_name=name, parent=context)
        if command is not None:
            with command.make_context(name, rest, parent=context):
                pass
    except click.exceptions.Exit:
        raise ConfigError("--help and --version start nothing; omit them") from None
    except click.BadParameter as error:
        # A file may exist only on the machine that runs the part, or in the folder of its service.
        if error.param is None or not isinstance(error.param.type, click.Path | click.File):
            raise
