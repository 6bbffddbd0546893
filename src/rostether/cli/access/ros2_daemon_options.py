"""Options of the `ros2` command that scripts have, and that need nothing here.

There is no daemon whose knowledge could be old, and subscribers ask for the quality of service that
publishers offer.
"""

from __future__ import annotations

import click

from rostether.cli.access.options import Function

_QOS = ("--qos-profile", "--qos-depth", "--qos-history", "--qos-reliability", "--qos-liveliness")


def daemon_habits(function: Function) -> Function:
    """Take --no-daemon and --spin-time."""
    function = click.option("--no-daemon", is_flag=True, expose_value=False, hidden=True)(function)
    return click.option("--spin-time", type=float, expose_value=False, hidden=True)(function)


def qos_habits(function: Function) -> Function:
    """Take the options for quality of service, but durability."""
    for name in _QOS:
        function = click.option(name, expose_value=False, hidden=True)(function)
    return daemon_habits(function)
