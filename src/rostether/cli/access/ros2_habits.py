"""Options of the `ros2` command that scripts use and that change nothing here.

There is no daemon whose knowledge could be old, and subscribers ask for the quality of service that
publishers offer.
"""

from __future__ import annotations

from rostether.cli.shell.option_group import ignored_options

daemon_habits = ignored_options("--spin-time", no_daemon="--no-daemon")
qos_habits = ignored_options(
    "--qos-profile",
    "--qos-depth",
    "--qos-history",
    "--qos-reliability",
    "--qos-liveliness",
    "--spin-time",
    no_daemon="--no-daemon",
)
