"""`rostether launch`: runs launch files, like roslaunch."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.gateway.options import (
    DEFAULT_ADDRESS,
    GatewayOptions,
    dashboard_option,
    viewer_access_options,
)
from rostether.cli.launch.launch_options import LaunchOptions, roslaunch_options
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb

if TYPE_CHECKING:
    from rostether.cli.launch.loaded_launch import LoadedLaunch
    from rostether.ros1.environment import RosEnvironment


def complete_launch(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return packages with launch files; after a package, its launch files."""
    from rostether.cli.shell.completion import is_plain
    from rostether.launch.sources import launch_files
    from rostether.packages.locate import package_folders

    packages = package_folders(os.environ, Path.cwd())
    words = ctx.params.get("words") or ()
    if words and words[0] in packages:
        names = launch_files(packages[words[0]])
    else:
        names = sorted(name for name, folder in packages.items() if launch_files(folder))
    return [name for name in names if name.startswith(incomplete) and is_plain(name)]


@verb(
    "launch",
    """
    rostether launch mearm_model display.launch            a file of a package
    rostether launch robot.launch port:=/dev/ttyACM1       a file, with an argument
    rostether launch mearm_model display.launch --nodes    list the nodes
    rostether launch robot.launch --dashboard              with a page for browsers
    rostether launch robot.launch --dump-params            list the parameters
    rostether launch robot.launch --ros-args               list its arguments
    """,
)
@option_group("options", LaunchOptions)
@click.argument(
    "words",
    nargs=-1,
    type=click.UNPROCESSED,
    metavar="[PACKAGE] FILE [NAME:=VALUE]...",
    shell_complete=complete_launch,
)
@dashboard_option
@viewer_access_options
@roslaunch_options
@graph_options(ros=False)
def launch(
    options: LaunchOptions,
    words: tuple[str, ...],
    dashboard: str | None,
    gateways: GatewayOptions,
    graph: GraphOptions,
) -> None:
    """Set the parameters and start the nodes of launch files; start a master if none runs.

    Packages are found on ROS_PACKAGE_PATH, in the catkin workspace around this folder, and below it; nothing
    needs to be built. Logs are kept in ~/.ros/log/latest. Ctrl-C ends all nodes in order.
    """
    from rostether.cli.access.ros1_access import read_environment
    from rostether.cli.dashboard.settings import DashboardSettings
    from rostether.cli.launch.launch_run import MasterSettings, run_launch, run_options
    from rostether.cli.launch.loaded_launch import load
    from rostether.cli.shell.running import run
    from rostether.launch.listing import summary_lines

    options.check()
    environment = read_environment(graph)
    loaded = load(words, runs_commands=options.runs_commands)
    if (listing := _listing(options, loaded, environment)) is not None:
        _print(listing)
        return
    loaded.warn()
    if not options.no_summary:
        _print(summary_lines(loaded.plan))
    views = tuple(loaded.views)
    address = DEFAULT_ADDRESS if dashboard is None and views else dashboard
    settings = DashboardSettings(address, gateways, views=views) if address is not None else None
    master = MasterSettings(
        environment, is_chosen=graph.master is not None, port=options.port, waits=options.wait
    )
    with _written_pid(options.pid_file):
        run(run_launch(loaded, master, run_options(options), settings), is_service=True)


def _listing(options: LaunchOptions, loaded: LoadedLaunch, environment: RosEnvironment) -> list[str] | None:
    from rostether.launch import listing

    plan = loaded.plan
    if options.lists_nodes:
        return listing.node_lines(plan)
    if options.dumps:
        return [listing.parameter_lines(plan)]
    if options.lists_arguments:
        return list(listing.argument_lines(plan))
    if options.lists_files:
        return listing.file_lines(plan)
    if options.args_of is not None:
        node = listing.find_node(plan, options.args_of, environment.namespace)
        return [listing.command_words(node, loaded.environ, environment.master_uri, loaded.locate)]
    if options.file_of is not None:
        return [listing.find_node(plan, options.file_of, environment.namespace).file]
    return None


@contextmanager
def _written_pid(file: Path | None) -> Iterator[None]:
    if file is None:
        yield
        return
    file.write_text(f"{os.getpid()}\n")
    try:
        yield
    finally:
        file.unlink(missing_ok=True)


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        write_line(line)
