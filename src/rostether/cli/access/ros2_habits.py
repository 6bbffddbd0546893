"""Options of the `ros2` command that are accepted for scripts and have no effect.

There is no daemon with outdated information, and subscribers request the quality of service of the
publishers.
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
