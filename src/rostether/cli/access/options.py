"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

from rostether.cli.shell.option_group import Function

msg_path_option = click.option(
    "--msg-path",
    "msg_paths",
    multiple=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Search this folder for packages, .msg and .srv files before ROS_PACKAGE_PATH; may be repeated.",
)


def window_option(default: int | None) -> Callable[[Function], Function]:
    """Return the option `-w` of the commands that measure over a window of messages."""
    return click.option(
        "-w",
        "--window",
        type=click.IntRange(min=2),
        default=default,
        metavar="COUNT",
        help=f"Measure over the last COUNT messages{f' ({default})' if default else ''}.",
    )


listen_option = click.option(
    "--listen",
    metavar="ADDRESS",
    help="Listen at this address for other machines; 0.0.0.0 for all addresses (default: loopback only).",
)
