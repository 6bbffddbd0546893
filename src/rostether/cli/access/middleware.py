"""Selects the ROS of a command: --ros1 or --ros2, else ROS_VERSION and RMW_IMPLEMENTATION, else ROS 1."""

from __future__ import annotations

import os
from collections.abc import Mapping
from enum import StrEnum
from importlib.util import find_spec

import click

ROS2_OPTION = "--ros2"
# The value of `--ros2` alone: the middleware in the environment, else the installed one.
ANY_MIDDLEWARE = "any"

# Names of middlewares that only rclpy reaches; none of them is an address or a topic.
_OF_RCLPY = frozenset(
    {"connext", "connextdds", "cyclone", "cyclonedds", "dds", "fastdds", "fastrtps", "gurumdds", "opensplice"}
)


class Middleware(StrEnum):
    """The way to reach a ROS 2 graph."""

    ZENOH = "zenoh"
    RCLPY = "rclpy"


class MiddlewareName(click.Choice[str]):
    """The values of `--ros2`; the error for another middleware names the value to use."""

    def __init__(self) -> None:
        super().__init__([*map(str, Middleware), ANY_MIDDLEWARE])

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the value. Fails with a usage error that names the right value."""
        if value == "rmw_zenoh_cpp":
            self.fail(f"write --ros2 zenoh instead of {value!r}", param, ctx)
        if value not in self.choices:
            self.fail(f"{value!r} is not zenoh or rclpy; use rclpy for other middlewares", param, ctx)
        return value


def is_middleware(word: str) -> bool:
    """Return whether a word names a middleware and so is the value of the `--ros2` before it."""
    return word in list(Middleware) or word.lower() in _OF_RCLPY or word.startswith("rmw_")


def chosen_middleware(
    *, ros1: bool = False, ros2: str | None = None, environ: Mapping[str, str] | None = None
) -> Middleware | None:
    """Return the middleware of the ROS 2 graph that a command selects, None for ROS 1 alone.

    Args:
        ros1: Whether `--ros1` was given. ros2: The value of `--ros2`, None if it was not given. environ:
        Environment variables, os.environ if None.
    """
    variables = os.environ if environ is None else environ
    if not ros2:
        if ros1 or variables.get("ROS_VERSION") == "1":
            return None
        if variables.get("ROS_VERSION") != "2" and not variables.get("RMW_IMPLEMENTATION"):
            return None
    if ros2 in list(Middleware):
        return Middleware(ros2)
    implementation = variables.get("RMW_IMPLEMENTATION", "")
    if implementation:
        # Only rclpy reaches middlewares other than zenoh.
        return Middleware.ZENOH if implementation == "rmw_zenoh_cpp" else Middleware.RCLPY
    return Middleware.RCLPY if find_spec("rclpy") is not None else Middleware.ZENOH
