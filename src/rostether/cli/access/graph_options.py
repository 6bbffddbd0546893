"""The options that select a graph, as one value."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from rostether.cli.shell.option_group import (
    EXISTING_FILE,
    Function,
    OptionalValueOption,
    add_flag,
    add_option,
    ignored_options,
    option_group,
)
from rostether.errors import ConfigError
from rostether.ros2.zenoh_reach import RouterChoice, ZenohReach

ROS2_OPTION = "--ros2"
# The value of `--ros2` alone: the middleware in the environment, else the installed one.
ANY_MIDDLEWARE = "any"

# Names of middlewares that only rclpy reaches. After --ros2, they are never addresses or topics.
_OF_RCLPY = frozenset(
    {"connext", "connextdds", "cyclone", "cyclonedds", "dds", "fastdds", "fastrtps", "gurumdds", "opensplice"}
)


class Middleware(StrEnum):
    """The way to reach a ROS 2 graph."""

    ZENOH = "zenoh"
    RCLPY = "rclpy"


class MiddlewareName(click.Choice[str]):
    """The type of the value of `--ros2`; the error for another middleware names the value to use."""

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
    """Return whether a word after `--ros2` names a middleware and is therefore its value."""
    return word in list(Middleware) or word.lower() in _OF_RCLPY or word.startswith("rmw_")


def chosen_middleware(*, ros1: bool = False, ros2: str | None = None) -> Middleware | None:
    """Return the middleware of the ROS 2 graph that a command selects, None for ROS 1 alone.

    `ros1` is true if `--ros1` was given; `ros2` is the value of `--ros2`, None if it was not given.
    """
    if not ros2:
        version = os.environ.get("ROS_VERSION")
        if ros1 or version == "1":
            return None
        if version != "2" and not os.environ.get("RMW_IMPLEMENTATION"):
            return None
    return middleware_of(ros2)


def middleware_of(ros2: str | None) -> Middleware:
    """Return the middleware for a value of `--ros2`; for `any` and None, that of the environment."""
    if ros2 in list(Middleware):
        return Middleware(ros2)
    if implementation := os.environ.get("RMW_IMPLEMENTATION"):
        # Only rclpy reaches middlewares other than zenoh.
        return Middleware.ZENOH if implementation == "rmw_zenoh_cpp" else Middleware.RCLPY
    return installed_middleware()


def installed_middleware() -> Middleware:
    """Return rclpy if it is installed, else zenoh."""
    return Middleware.RCLPY if find_spec("rclpy") is not None else Middleware.ZENOH


@dataclass(frozen=True, slots=True)
class GraphOptions:
    """The graph that a command line selects.

    `ros2` is None for ROS 1 alone. `allow` are networks in CIDR form that may connect to this node, and
    `arguments` are ROS arguments such as `__name:=x`, by name.
    """

    ros1: bool = False
    ros2: Middleware | None = None
    master: str | None = None
    allow: tuple[str, ...] = ()
    arguments: Mapping[str, str] = field(default_factory=dict)
    zenoh: ZenohReach = field(default_factory=ZenohReach)
    params_files: tuple[Path, ...] = ()

    @property
    def uses_ros1(self) -> bool:
        """Whether the ROS 1 graph is selected, alone or with ROS 2."""
        return self.ros1 or self.ros2 is None

    @property
    def is_ros2_alone(self) -> bool:
        """Whether only the ROS 2 graph is selected."""
        return not self.uses_ros1

    def refuse_unused(self) -> None:
        """Refuse options for a ROS 2 graph that is not selected. Raises ConfigError."""
        zenoh = self.zenoh
        if self.ros2 is not Middleware.ZENOH and zenoh != ZenohReach():
            options = {"--zenoh-connect": zenoh.connect, "--zenoh-listen": zenoh.listen}
            option = next((name for name, value in options.items() if value), "--zenoh-router")
            raise ConfigError(f"{option} has an effect only with --ros2 zenoh; add that, or omit {option}")
        if self.ros2 is None and self.params_files:
            raise ConfigError("--params-file has an effect only with --ros2; add that, or omit the file")

    def node_name(self, purpose: str) -> str:
        """Return the name of the command's node: `__name:=`, else a unique one that begins with `purpose`."""
        # Imported here because it needs socket and random, and most commands have no node.
        from rostether.mechanisms.anonymous import anonymous_name

        return self.arguments.get("__name") or anonymous_name(purpose)


_TOOL_MASTER = "The ROS master (default: ROS_MASTER_URI, or http://localhost:11311)."
_SERVED_MASTER = "The ROS master to join; the command waits for it."
_TOOL_ALLOW = "Accept connections to this node from these addresses only (if ROS_IP is set); may be repeated."
_SERVED_ALLOW = "Accept network connections from these addresses only, e.g. 192.168.1.0/24; may be repeated."

# Options of the tools of ROS 2 that scripts pass; they have no effect here.
_IGNORED_DAEMON_OPTIONS = ignored_options("--spin-time", flags=["--no-daemon"])

_ROS1_HELP = "Use the ROS 1 graph even if ROS 2 is sourced"


def ros2_option(explanation: str, metavar: str = "[zenoh|rclpy]") -> Callable[[Function], Function]:
    """Return a decorator that adds `--ros2 [MIDDLEWARE]`; `explanation` is its line in the help."""
    return add_option(
        ROS2_OPTION,
        explanation,
        cls=OptionalValueOption,
        alone=ANY_MIDDLEWARE,
        is_value=is_middleware,
        type=MiddlewareName(),
        metavar=metavar,
    )


ROS2_CHOICE = ros2_option("Use the ROS 2 graph, through zenoh or an installed rclpy.")
_REACH_OPTIONS = (
    add_option(
        "--zenoh-connect ENDPOINT",
        "With --ros2 zenoh, connect to this router, e.g. tcp/192.168.1.7:7447; may be repeated.",
        multiple=True,
    ),
    add_option(
        "--zenoh-listen ENDPOINT",
        "With --ros2 zenoh, listen on this endpoint, e.g. tcp/0.0.0.0:7447; may be repeated.",
        multiple=True,
    ),
)
_SERVING_OPTIONS = (
    add_option(
        "--zenoh-router",
        "With --ros2 zenoh, when to start the zenoh router of this machine; auto: if there is none. The "
        "router listens on localhost:7447; with `always` and --zenoh-listen, only at those endpoints.",
        type=click.Choice(["auto", "never", "always"]),
        default="auto",
        show_default=True,
    ),
    add_option(
        "--params-file params_files FILE",
        "With --ros2, a YAML file of node parameters; may be repeated.",
        multiple=True,
        type=EXISTING_FILE,
    ),
)


def graph_options(
    *, served: bool = False, master: bool = True, ros: bool = True, allow: bool = False, zenoh: bool = False
) -> Callable[[Function], Function]:
    """Return a decorator that adds the graph options; the verb gets them as `graph`.

    Args:
        served: Whether other nodes and boards depend on the command: it has --allow, and with `ros` all zenoh
            options and --params-file.
        master: Whether to add --master.
        ros: Whether to add --ros1 and --ros2; without them the graph is ROS 1.
        allow: Whether to add --allow.
        zenoh: Whether to add --zenoh-connect and --zenoh-listen; the command can then use both graphs.
    """
    options: list[Callable[[Any], Any]] = []
    takes_both = served or zenoh
    if master:
        options.append(add_option("--master URI", _SERVED_MASTER if served else _TOOL_MASTER))
    if ros:
        end = "; with --ros2, use both." if takes_both else "."
        options += (add_flag("--ros1", _ROS1_HELP + end), ROS2_CHOICE)
    if zenoh or (served and ros):
        options += _REACH_OPTIONS
    if served and ros:
        options += _SERVING_OPTIONS
    if ros and not takes_both:
        options.append(_IGNORED_DAEMON_OPTIONS)
    if allow or served:
        text = _SERVED_ALLOW if served else _TOOL_ALLOW
        options.append(add_option("--allow CIDR", text, multiple=True))
    build: Callable[..., GraphOptions] = _chosen_graph if takes_both else _one_graph
    if not ros:
        # The verb may have --ros1 and --ros2 with another meaning.
        build = partial(_chosen_graph, ros1=True, ros2=None)
    return option_group("graph", build, options, heading="ROS graph")


def ros_arguments() -> Mapping[str, str]:
    """Return the ROS arguments such as `__name:=x` of the running command, which `main` stored."""
    context = click.get_current_context(silent=True)
    arguments = context.find_root().obj if context is not None else None
    return arguments if isinstance(arguments, dict) else {}


def _one_graph(
    *, ros1: bool = False, ros2: str | None = None, master: str | None = None, allow: tuple[str, ...] = ()
) -> GraphOptions:
    if ros1 and ros2:
        raise click.UsageError("this command uses one graph; give --ros1 or --ros2, not both")
    graph = _chosen_graph(ros1=ros1, ros2=ros2, master=master, allow=allow)
    if master and graph.ros2 is not None:
        raise click.UsageError("--master works on ROS 1 only; omit it or add --ros1")
    return graph


def _chosen_graph(
    *,
    ros1: bool = False,
    ros2: str | None = None,
    master: str | None = None,
    allow: tuple[str, ...] = (),
    zenoh_connect: tuple[str, ...] = (),
    zenoh_listen: tuple[str, ...] = (),
    zenoh_router: str = "auto",
    params_files: tuple[Path, ...] = (),
) -> GraphOptions:
    return GraphOptions(
        ros1=ros1,
        ros2=chosen_middleware(ros1=ros1, ros2=ros2),
        master=master,
        allow=allow,
        arguments=ros_arguments(),
        zenoh=ZenohReach(RouterChoice(zenoh_router), zenoh_connect, zenoh_listen),
        params_files=params_files,
    )
