"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Function = TypeVar("Function", bound=Callable[..., Any])

msg_path_option = click.option(
    "--msg-path",
    "msg_paths",
    multiple=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="A folder of packages or of .msg and .srv files; may be repeated, before ROS_PACKAGE_PATH.",
)

master_option = click.option(
    "--master", metavar="URI", help="The ROS master, instead of ROS_MASTER_URI (http://localhost:11311)."
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


allow_option = click.option(
    "--allow",
    "allowed",
    multiple=True,
    metavar="CIDR",
    help="Who may connect to what listens beyond loopback, such as 192.168.1.0/24; may be repeated.",
)

ALLOWED = "rostether.allowed"
"""Where the context of a command keeps what its `--allow` said; `read_environment` heeds it."""


def _remember_allowed(context: click.Context, _parameter: click.Parameter, networks: tuple[str, ...]) -> None:
    context.meta[ALLOWED] = networks


tool_allow_option = click.option(
    "--allow",
    multiple=True,
    metavar="CIDR",
    expose_value=False,
    callback=_remember_allowed,
    help="Which machines may connect to this node (where ROS_IP lets others in); may be repeated.",
)

listen_option = click.option(
    "--listen",
    metavar="ADDRESS",
    help="Let other machines reach us at this address of ours; 0.0.0.0: at any (default: loopback only).",
)
