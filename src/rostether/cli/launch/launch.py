"""`rostether launch`: runs launch files, like roslaunch."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.ros1_access import joining_ros1, no_master
from rostether.cli.access.served_graphs import ServedGraphs, master_answers, used_master
from rostether.cli.dashboard.beside import DashboardSettings, dashboard_beside, dashboard_option
from rostether.cli.dashboard.served import has_browser, open_browser
from rostether.cli.gateway.options import DEFAULT_PLACE, GatewayOptions, viewer_access_options
from rostether.cli.launch.launch_options import LaunchOptions, launch_options, roslaunch_options
from rostether.cli.launch.loaded_launch import LoadedLaunch
from rostether.cli.shell.failures import print_error
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import Verb
from rostether.errors import MasterUnreachableError
from rostether.graph.ports import Level
from rostether.launch.node_process import StopLimits
from rostether.launch.plan import Output
from rostether.launch.runner import RunOptions, run_plan
from rostether.ros1.environment import RosEnvironment

# The interval of checks while waiting for a master.
_WAIT_S = 0.2


def _complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from rostether.cli.launch.sources import complete_launch

    return complete_launch(ctx, param, incomplete)


@click.command(
    "launch",
    cls=Verb,
    examples="""
    rostether launch mearm_model display.launch            a file of a package
    rostether launch robot.launch port:=/dev/ttyACM1       a file, with an argument
    rostether launch mearm_model display.launch --nodes    list the nodes
    rostether launch robot.launch --dashboard              with a page for browsers
    rostether launch robot.launch --dump-params            list the parameters
    rostether launch robot.launch --ros-args               list its arguments
    """,
)
@launch_options
@click.argument(
    "words",
    nargs=-1,
    type=click.UNPROCESSED,
    metavar="[PACKAGE] FILE [NAME:=VALUE]...",
    shell_complete=_complete,
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
    from rostether.cli.dashboard.beside import DashboardSettings
    from rostether.cli.launch.listing import summary_lines
    from rostether.cli.launch.loaded_launch import load
    from rostether.cli.shell.running import run

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
    place = DEFAULT_PLACE if dashboard is None and views else dashboard
    settings = DashboardSettings(place, gateways, views=views) if place is not None else None
    master = MasterSettings(
        environment, is_chosen=graph.master is not None, port=options.port, waits=options.wait
    )
    with _written_pid(options.pid_file):
        run(run_launch(loaded, master, run_options(options), settings), is_service=True)


def _listing(options: LaunchOptions, loaded: LoadedLaunch, environment: RosEnvironment) -> list[str] | None:
    from rostether.cli.launch import listing

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


@dataclass(frozen=True, slots=True)
class MasterSettings:
    """The master of the nodes; `is_chosen` if an option named it, `waits` if none may be started."""

    environment: RosEnvironment
    is_chosen: bool
    port: int | None
    waits: bool


async def run_launch(
    loaded: LoadedLaunch, master: MasterSettings, options: RunOptions, dashboard: DashboardSettings | None
) -> None:
    """Run the nodes until all have ended. Raises click's Exit if a required one failed."""
    if master.waits and not await master_answers(master.environment):
        write_line(f"Waiting for the ROS master at {master.environment.master_uri}")
        while not await master_answers(master.environment):  # noqa: ASYNC110 - there is no event
            await asyncio.sleep(_WAIT_S)
    async with used_master(master.environment, is_chosen=master.is_chosen, port=master.port) as used:
        write_line(used.line)
        graphs = ServedGraphs(joining_ros1(used.environment), used.environment, ())
        try:
            async with dashboard_beside(dashboard, graphs, loaded.package_folders, _report) as served:
                if served is not None and has_browser(os.environ):
                    for url in served.view_urls:
                        await open_browser(url)
                succeeded = await run_plan(
                    loaded.plan,
                    master_uri=used.environment.master_uri,
                    environ=loaded.environ,
                    locate=loaded.locate,
                    report=_report,
                    options=replace(options, stays=used.is_ours or dashboard is not None),
                )
        except MasterUnreachableError as error:
            raise no_master(used.environment, error) from error
    if not succeeded:
        raise click.exceptions.Exit(1)


def run_options(options: LaunchOptions) -> RunOptions:
    """Return how to run the nodes."""
    return RunOptions(
        output=Output.SCREEN if options.screen else Output.LOG if options.to_log else None,
        all_required=options.required,
        stop_limits=StopLimits(options.sigint_timeout, options.sigterm_timeout),
    )


def _report(level: int, text: str) -> None:
    if level >= Level.ERROR:
        print_error(text)
    elif level >= Level.WARN:
        warn(f"warning: {text}")
    else:
        write_line(text)
