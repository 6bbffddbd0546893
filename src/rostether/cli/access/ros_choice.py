"""Which ROS a command means: as --ros1 or --ros2 says, else ROS_VERSION, RMW_IMPLEMENTATION, else ROS 1."""

from __future__ import annotations

import os
from collections.abc import Mapping
from enum import StrEnum
from importlib.util import find_spec

import click

from rostether.cli.access.options import Function

ROS2_OPTION = "--ros2"
ANY_MIDDLEWARE = "any"
"""What `--ros2` alone means: the middleware that the environment names, else the one that is installed."""

_OF_RCLPY = frozenset(
    {"connext", "connextdds", "cyclone", "cyclonedds", "dds", "fastdds", "fastrtps", "gurumdds", "opensplice"}
)
"""What people call middlewares that only rclpy reaches: no address or topic is meant by these."""

_CHOICE_KEY = "rostether.ros_choice"


class Middleware(StrEnum):
    """How a ROS 2 graph is reached."""

    ZENOH = "zenoh"
    RCLPY = "rclpy"


class _MiddlewareName(click.Choice[str]):
    """What may stand behind `--ros2`; says of other middlewares how they are reached."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if value == "rmw_zenoh_cpp":
            self.fail(f"{value!r} is written --ros2 zenoh", param, ctx)
        if value not in self.choices:
            self.fail(
                f"{value!r} is neither zenoh nor rclpy; rclpy reaches all that is not zenoh", param, ctx
            )
        return value


def _is_middleware(word: str) -> bool:
    return word in list(Middleware) or word.lower() in _OF_RCLPY or word.startswith("rmw_")


def with_middleware(arguments: list[str]) -> list[str]:
    """Give a `--ros2` that stands alone its value: the word behind it counts only if it is a middleware."""
    named = [
        f"{each}={ANY_MIDDLEWARE}" if each == ROS2_OPTION and not _is_middleware(following) else each
        for each, following in zip(arguments, [*arguments[1:], ""], strict=False)
    ]
    end = arguments.index("--") if "--" in arguments else len(arguments)
    return named[:end] + arguments[end:]


def _keep(context: click.Context, parameter: click.Parameter, value: object) -> object:
    if value:
        chosen = context.meta.setdefault(_CHOICE_KEY, {})
        chosen[parameter.name] = value
    return value


def ros2_option(function: Function) -> Function:
    """Add `--ros2 [zenoh|rclpy]`; `chosen_ros2` tells what was typed."""
    return click.option(
        ROS2_OPTION,
        type=_MiddlewareName([*map(str, Middleware), ANY_MIDDLEWARE]),
        metavar="[zenoh|rclpy]",
        expose_value=False,
        callback=_keep,
        help="Use the ROS 2 graph, over zenoh or an installed rclpy.",
    )(function)


def ros1_option(function: Function) -> Function:
    """Add `--ros1`, for those who have a ROS 2 sourced, or want both."""
    return click.option(
        "--ros1",
        is_flag=True,
        expose_value=False,
        callback=_keep,
        help="Use the ROS 1 graph, also where a ROS 2 is sourced; with --ros2: both at once.",
    )(function)


def _typed() -> Mapping[str, str]:
    context = click.get_current_context(silent=True)
    typed: Mapping[str, str] = context.meta.get(_CHOICE_KEY, {}) if context is not None else {}
    return typed


def chosen_ros2(environ: Mapping[str, str] | None = None) -> Middleware | None:
    """Return the middleware of the ROS 2 graph that this command line means, None if it means none."""
    variables = os.environ if environ is None else environ
    typed = _typed()
    named = typed.get("ros2", "")
    if not named:
        if "ros1" in typed or variables.get("ROS_VERSION") == "1":
            return None
        if variables.get("ROS_VERSION") != "2" and not variables.get("RMW_IMPLEMENTATION"):
            return None
    if named in list(Middleware):
        return Middleware(named)
    implementation = variables.get("RMW_IMPLEMENTATION", "")
    if implementation:
        # Other middlewares than zenoh are within reach of rclpy alone.
        return Middleware.ZENOH if implementation == "rmw_zenoh_cpp" else Middleware.RCLPY
    return Middleware.RCLPY if find_spec("rclpy") is not None else Middleware.ZENOH


def typed_ros1() -> bool:
    """Tell whether `--ros1` was typed."""
    return "ros1" in _typed()


def chosen_ros1() -> bool:
    """Tell whether this command line means the ROS 1 graph, alone or beside ROS 2."""
    return "ros1" in _typed() or chosen_ros2() is None
