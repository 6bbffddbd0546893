"""make_libraries.py as a role: runs `firmware lib` with the arguments of make_libraries.py."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.firmware.lib import firmware_lib
from rostether.cli.shell.verbs import Verb


@click.command(
    "make-libraries",
    cls=Verb,
    examples="""
    rostether role make-libraries ~/Arduino/libraries
    rostether role make-libraries . std_msgs mearm_model
    """,
)
@click.argument("directory", metavar="[DIR]", type=click.Path(path_type=Path), default=Path())
@click.argument("packages", nargs=-1, metavar="[PACKAGE]...")
@click.pass_context
def make_libraries(context: click.Context, directory: Path, packages: tuple[str, ...]) -> None:
    """Write ros_lib for Arduino to DIR (default: this folder), with the messages of all packages or of the
    named ones.
    """
    context.invoke(
        firmware_lib, directory=directory, sketch=None, packages=packages, msg_paths=(), as_json=False
    )
