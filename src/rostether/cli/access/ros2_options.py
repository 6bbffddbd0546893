"""What `serve` and its like take beside --ros2: whom zenoh talks with, and files of parameters."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import click

from rostether.cli.access.options import Function
from rostether.cli.access.ros2_access import ZenohReach
from rostether.cli.access.ros_choice import ros1_option, ros2_option

_KEY = "rostether.ros2_options"


@dataclass(frozen=True, slots=True)
class Ros2Options:
    """Everything about ROS 2 but the middleware."""

    reach: ZenohReach = field(default_factory=ZenohReach)
    params_files: tuple[Path, ...] = ()


def _keep(context: click.Context, parameter: click.Parameter, value: object) -> object:
    context.meta.setdefault(_KEY, {})[parameter.name] = value
    return value


_REACH_OPTIONS = (
    click.option(
        "--zenoh-connect",
        multiple=True,
        metavar="ENDPOINT",
        expose_value=False,
        callback=_keep,
        help="With --ros2 zenoh, a router to join, as tcp/192.168.1.7:7447; may be repeated.",
    ),
    click.option(
        "--zenoh-listen",
        multiple=True,
        metavar="ENDPOINT",
        expose_value=False,
        callback=_keep,
        help="With --ros2 zenoh, let others reach us there, as tcp/0.0.0.0:7447; may be repeated.",
    ),
)
_OPTIONS = (
    *_REACH_OPTIONS,
    click.option(
        "--zenoh-router",
        type=click.Choice(["auto", "never", "always"]),
        default="auto",
        show_default=True,
        expose_value=False,
        callback=_keep,
        help="With --ros2 zenoh, be the router of this machine: when there is none, never, or always. A "
        "router listens at localhost:7447; with always, only at --zenoh-listen where that is given.",
    ),
    click.option(
        "--params-file",
        "params_files",
        multiple=True,
        type=click.Path(path_type=Path, exists=True, dir_okay=False),
        metavar="FILE",
        expose_value=False,
        callback=_keep,
        help="With --ros2, a YAML file of parameters for the nodes; may be repeated.",
    ),
)


def zenoh_reach_options(function: Function) -> Function:
    """Add --zenoh-connect and --zenoh-listen; `read_ros2_options` returns what was typed."""
    for option in reversed(_REACH_OPTIONS):
        function = option(function)
    return function


def ros2_options(function: Function) -> Function:
    """Add --ros1, --ros2 and what goes with it; `read_ros2_options` returns what was typed."""
    for option in reversed(_OPTIONS):
        function = option(function)
    return ros1_option(ros2_option(function))


def read_ros2_options() -> Ros2Options:
    """Return what was typed for ROS 2 on this command line."""
    context = click.get_current_context(silent=True)
    typed = context.meta.get(_KEY) if context is not None else None
    if typed is None:
        return Ros2Options()
    reach = ZenohReach(typed["zenoh_connect"], typed["zenoh_listen"], typed.get("zenoh_router", "auto"))
    return Ros2Options(reach, typed.get("params_files", ()))
