"""`rostether param list|get|set|delete|describe|dump|load`: reads and writes parameters."""

from __future__ import annotations

from collections.abc import Coroutine
from pathlib import Path
from typing import Any, Protocol

import click

from rostether.cli.access.completions import complete_params
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.param.options import GetOptions, ParamListing, SetOptions, verbose_option
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.output import json_option
from rostether.cli.shell.verbs import verb

# `param set /x -5` sets minus five.
_NEGATIVE_NUMBERS = {"ignore_unknown_options": True}


class Params(Protocol):
    """The parameters of one graph. Each method is a whole command; it raises RostetherError or UsageError.

    A parameter of ROS 2 is given as a node and a name, or as both in one full name.
    """

    async def list_params(self, wanted: ParamListing) -> None:
        """Print the names of parameters."""

    async def get(self, name: str, parameter: str | None, options: GetOptions) -> None:
        """Print a parameter."""

    def set_param(self, words: tuple[str, ...], options: SetOptions) -> Coroutine[Any, Any, None]:
        """Set a parameter; `words` are NAME VALUE, or with ROS 2 NODE NAME VALUE."""

    async def delete(self, name: str, parameter: str | None, *, verbose: bool) -> None:
        """Delete a parameter."""

    async def dump(self, file: Path | None, namespace: str, /, *, verbose: bool) -> None:
        """Write parameters as YAML; with ROS 2, `file` is the node."""

    def load(self, file: Path, namespace: str, /, *, verbose: bool) -> Coroutine[Any, Any, None]:
        """Set the parameters of a YAML file; with ROS 2, `file` is the node and `namespace` the file."""


def params_of(graph: GraphOptions) -> Params:
    """Return the parameters of the graph that the command line selects."""
    if graph.ros2 is None:
        from rostether.cli.param.ros1_params import Ros1Params

        return Ros1Params(graph)
    from rostether.cli.param.ros2_params import Ros2Params

    return Ros2Params(graph)


@verb("list", "rostether param list\nrostether param list /board")
@option_group("wanted", ParamListing)
@graph_options()
async def list_params(wanted: ParamListing, graph: GraphOptions) -> None:
    """List the names of all parameters, or of those in a namespace or, with --ros2, of a node."""
    await params_of(graph).list_params(wanted)


@verb("get", "rostether param get /rosdistro\nrostether param get -p /")
@click.argument("name", shell_complete=complete_params)
@click.argument("parameter", metavar="[NAME]", required=False)
@option_group("options", GetOptions)
@graph_options()
async def get(name: str, parameter: str | None, options: GetOptions, graph: GraphOptions) -> None:
    """Print a parameter, or all parameters of a namespace, in YAML; with --ros2, give NODE NAME."""
    await params_of(graph).get(name, parameter, options)


@verb(
    "set",
    """
    rostether param set /blink_hz 2.5
    rostether param set /arm "{joints: [0.1, deg(90)], name: left}"
    rostether param set /robot_description -t robot.urdf
    rostether param set --ros2 /board gain 0.5
    """,
    context_settings=_NEGATIVE_NUMBERS,
)
@click.argument("name", shell_complete=complete_params)
@click.argument("value", required=False)
@click.argument("more", nargs=-1, metavar="[VALUE]...")
@option_group("options", SetOptions)
@graph_options()
def set_param(
    name: str, value: str | None, more: tuple[str, ...], options: SetOptions, graph: GraphOptions
) -> Coroutine[Any, Any, None]:
    """Set a parameter to a value in YAML.

    A mapping sets only the parameters that it names. With --ros2, give NODE NAME VALUE.
    """
    return params_of(graph).set_param((name, *((value,) if value is not None else ()), *more), options)


@verb("delete", "rostether param delete /blink_hz")
@click.argument("name", shell_complete=complete_params)
@click.argument("parameter", metavar="[NAME]", required=False)
@verbose_option
@graph_options()
async def delete(name: str, parameter: str | None, verbose: bool, graph: GraphOptions) -> None:
    """Delete a parameter, or all parameters of a namespace; with --ros2, give NODE NAME."""
    await params_of(graph).delete(name, parameter, verbose=verbose)


@verb("describe", "rostether param describe --ros2 /board gain")
@click.argument("node")
@click.argument("names", metavar="NAME...", nargs=-1, required=True)
@json_option
@graph_options()
async def describe(node: str, names: tuple[str, ...], as_json: bool, graph: GraphOptions) -> None:
    """Show the type, the limits and the description of a ROS 2 node's parameters."""
    if graph.ros2 is None:
        raise click.UsageError(
            "ROS 1 parameters have no description; use --ros2 for the parameters of a ROS 2 node"
        )
    from rostether.cli.param.ros2_params import Ros2Params

    await Ros2Params(graph).describe(node, names, as_json=as_json)


@verb("dump", "rostether param dump settings.yaml\nrostether param dump - /board")
@click.argument("file", required=False, type=click.Path(path_type=Path, allow_dash=True))
@click.argument("namespace", default="")
@verbose_option
@graph_options()
async def dump_params(file: Path | None, namespace: str, verbose: bool, graph: GraphOptions) -> None:
    """Write parameters to a YAML file; without a file, or with -, to stdout.

    With --ros2, give the node instead of the file; its parameters go to stdout.
    """
    await params_of(graph).dump(file, namespace, verbose=verbose)


@verb("load", "rostether param load settings.yaml\nrostether param load settings.yaml /board")
@click.argument("file", type=click.Path(path_type=Path, allow_dash=True))
@click.argument("namespace", default="")
@verbose_option
@graph_options()
def load(file: Path, namespace: str, verbose: bool, graph: GraphOptions) -> Coroutine[Any, Any, None]:
    """Set the parameters of a YAML file (- is stdin), in a namespace if one is given.

    With --ros2, give NODE FILE.
    """
    return params_of(graph).load(file, namespace, verbose=verbose)
