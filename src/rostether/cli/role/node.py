"""Runs a standard ROS node, with the arguments that every ROS node accepts."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

import click
from msgspec.structs import replace

from rostether.cli.access.graph_options import ROS2_CHOICE, GraphOptions, middleware_of, ros_arguments
from rostether.cli.access.ros1_access import read_environment, type_store
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import Verb
from rostether.graph.ports import Graph, Level
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.tasks import run_until
from rostether.mechanisms.text import did_you_mean
from rostether.mechanisms.waiting import wait_for_master
from rostether.names.remap import Arguments, parse_arguments
from rostether.ros1.environment import RosEnvironment

if TYPE_CHECKING:
    from rostether.graph.typed_graph import TypedGraph

Main: TypeAlias = Callable[["TypedGraph", Arguments], Awaitable[None]]

NODE_WORDS = "[NAME:=VALUE]..."

# A node's arguments, as every ROS node accepts them.
node_words = click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar=NODE_WORDS)


class RoleVerb(Verb):
    """A command with a node's arguments: there, `-0.1` is a number, not an option."""

    ignore_unknown_options = True

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, is_service=True, **kwargs)


def node_arguments(words: Sequence[str]) -> Arguments:
    """Sort a node's words: remappings, private parameters, ROS arguments and the rest. Raises ConfigError."""
    return replace(parse_arguments(words), special=dict(ros_arguments()))


def node_environment(arguments: Arguments) -> RosEnvironment:
    """Return the ROS environment of a node. Raises ConfigError."""
    return read_environment(GraphOptions(arguments=arguments.special))


@asynccontextmanager
async def role_node(
    arguments: Arguments, default_name: str, ros2: str | None = None
) -> AsyncIterator[TypedGraph]:
    """Join as a node named `default_name` or by `__name:=`; its private parameters are set first.

    `ros2` is the value of `--ros2`, None for ROS 1. Waits for the master, as rospy's nodes do. Raises
    InvalidNameError, ConfigError, GraphError.
    """
    from rostether.graph.typed_graph import TypedGraph

    name = arguments.special.get("__name", default_name)
    async with _on_ros1(arguments, name) if ros2 is None else _on_ros2(arguments, name, ros2) as graph:
        for parameter, value in arguments.private_params.items():
            await graph.set_param(f"~{parameter}", value)
        yield TypedGraph(graph, type_store())


@asynccontextmanager
async def _on_ros1(arguments: Arguments, name: str) -> AsyncIterator[Graph]:
    from rostether.ros1.node.node import join_ros1

    environment = node_environment(arguments)
    graph = await wait_for_master(
        lambda: join_ros1(
            name, environment=environment, namespace=environment.namespace, remappings=arguments.remappings
        ),
        lambda _: warn(f"waiting for a ROS master at {environment.master_uri}"),
    )
    async with closed_at_end(graph):
        yield graph


@asynccontextmanager
async def _on_ros2(arguments: Arguments, name: str, ros2: str) -> AsyncIterator[Graph]:
    async with ros2_access(middleware_of(ros2)) as access:
        namespace = arguments.special.get("__ns", "/")
        graph = await access.join(name, namespace=namespace, remappings=arguments.remappings)
        async with closed_at_end(graph):
            yield graph


async def run_role(default_name: str, words: Sequence[str], main: Main, ros2: str | None = None) -> None:
    """Run a node until `main` returns, or the node or the process is shut down.

    `main` gets the graph and the node's arguments; `ros2` is the value of `--ros2`, None for ROS 1. Raises
    ConfigError, InvalidNameError, GraphError, and the errors of `main`.
    """
    arguments = node_arguments(words)
    _warn_of_mistakes(arguments)
    async with role_node(arguments, default_name, ros2) as graph:
        await run_until(main(graph, arguments), graph.raw.wait_closed())


def _warn_of_mistakes(arguments: Arguments) -> None:
    # Not errors: launch files may have arguments for another program with the same name.
    for word in arguments.rest:
        if word.startswith("--"):
            warn(f"WARNING: ignored {word!r:.100}; a node's parameters are written _name:=value")
    context = click.get_current_context(silent=True)
    documented = re.findall(r"~(\w+)", (context and context.command.help) or "")
    for name, value in arguments.remappings.items():
        if name in documented:
            given = f"{name}:={value}"
            warn(f"WARNING: {given!r:.100} renames a topic; the parameter is written _{name}:=value")
    for name in arguments.private_params.keys() - set(documented):
        if hint := did_you_mean(name, documented, prefix="_"):
            warn(f"WARNING: this node has no parameter _{name:.100}; {hint}")


def role(
    verb: str,
    examples: str,
    *,
    metavar: str = NODE_WORDS,
    has_ros2: bool = False,
    node_name: Callable[[str, Arguments], str] = lambda default, _: default,
) -> Callable[[Main], click.Command]:
    """Return a decorator that makes a node's coroutine a verb; its docstring is the help.

    With `has_ros2` it has --ros2. `node_name` returns the node's usual name from the verb with underscores
    and the node's arguments; it may raise ConfigError for wrong arguments.
    """

    def decorate(main: Main) -> click.Command:
        async def command(arguments: tuple[str, ...], ros2: str | None = None) -> None:
            name = node_name(verb.replace("-", "_"), node_arguments(arguments))
            await run_role(name, arguments, main, ros2)

        command.__doc__ = main.__doc__
        words = click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar=metavar)
        decorated = words(ROS2_CHOICE(command) if has_ros2 else command)
        return click.command(verb, cls=RoleVerb, examples=examples)(decorated)

    return decorate


def reporter(graph: TypedGraph) -> Callable[[Level, str], None]:
    """Return a function that prints a line and logs it on the graph."""

    def report(level: Level, text: str) -> None:
        graph.log(level, text)
        (warn if level > Level.INFO else write_line)(text)

    return report
