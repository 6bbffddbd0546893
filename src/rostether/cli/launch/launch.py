"""`rostether launch`: what launch files ask for, like roslaunch."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.dashboard.options import dashboard_option
from rostether.cli.gateway.options import DEFAULT_PLACE, GatewayOptions, viewer_access_options
from rostether.cli.shell.input_files import STDIN, read_bytes
from rostether.cli.shell.option_group import ignored_options, option_group
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import Verb
from rostether.errors import MasterUnreachableError

if TYPE_CHECKING:
    from rostether.cli.dashboard.served import DashboardSettings
    from rostether.cli.launch.sources import LaunchSources
    from rostether.launch.command_line import Locate, Program, Replaced
    from rostether.launch.plan import LaunchPlan
    from rostether.launch.runner import RunOptions
    from rostether.ros1.environment import RosEnvironment

_WAIT_S = 0.2  # how often a master that is waited for is asked
_PACKAGE_PATH = "ROS_PACKAGE_PATH"
_MAX_PATH_CHARS = 100_000  # Linux starts no process with a variable of 128 KB
_SECONDS = click.FloatRange(0, min_open=True)


# roslaunch has these; scripts use them, and they change nothing here.
_roslaunch_options = ignored_options(
    "-w --numworkers",
    "-t --timeout",
    "--master-logger-level",
    local="--local",
    log_check="--skip-log-check",
    title="--disable-title",
    verbose="-v --verbose",
)


def _complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from rostether.cli.launch.sources import complete_launch

    return complete_launch(ctx, param, incomplete)


@dataclass(frozen=True, slots=True)
class LaunchOptions:
    """The options of `launch`."""

    lists_nodes: bool
    dumps: bool
    lists_arguments: bool
    lists_files: bool
    args_of: str | None
    file_of: str | None
    screen: bool
    to_log: bool
    required: bool
    wait: bool
    port: int | None
    no_summary: bool
    sigint_timeout: float
    sigterm_timeout: float
    pid_file: Path | None


_launch_options = option_group(
    "options",
    LaunchOptions,
    (
        click.option("--nodes", "lists_nodes", is_flag=True, help="Only print the names of the nodes."),
        click.option("--dump-params", "dumps", is_flag=True, help="Only print the parameters, as YAML."),
        click.option(
            "--ros-args", "lists_arguments", is_flag=True, help="Print the arguments of the launch file."
        ),
        click.option(
            "--files", "lists_files", is_flag=True, help="Print the file and all files that it includes."
        ),
        click.option("--args", "args_of", metavar="NODE", help="Print the command line of a node."),
        click.option("--find-node", "file_of", metavar="NODE", help="Print the file that defines a node."),
        click.option("--screen", is_flag=True, help="Show the output of all nodes."),
        click.option(
            "--log", "to_log", is_flag=True, help="Write the output of all nodes to their log files."
        ),
        click.option("--required", is_flag=True, help="Stop all nodes when any of them ends."),
        click.option("--wait", is_flag=True, help="Wait for a master instead of starting one."),
        click.option(
            "-p",
            "--port",
            type=click.IntRange(1, 65535),
            help="Port for the ROS master, which is started if none runs.",
        ),
        click.option("--no-summary", is_flag=True, help="Do not print the summary."),
        click.option(
            "--sigint-timeout",
            type=_SECONDS,
            default=15.0,
            metavar="S",
            help="Seconds that a node has to end after SIGINT (15).",
        ),
        click.option(
            "--sigterm-timeout",
            type=_SECONDS,
            default=2.0,
            metavar="S",
            help="Seconds that a node has to end after SIGTERM (2).",
        ),
        click.option(
            "--pid",
            "pid_file",
            type=click.Path(path_type=Path, dir_okay=False),
            help="Write the process id of this command to a file.",
        ),
    ),
)


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
@_launch_options
@click.argument(
    "words",
    nargs=-1,
    type=click.UNPROCESSED,
    metavar="[PACKAGE] FILE [NAME:=VALUE]...",
    shell_complete=_complete,
)
@dashboard_option
@viewer_access_options
@_roslaunch_options
@graph_options(ros=False)
def launch(  # noqa: C901, PLR0912, PLR0915 - one branch for each thing that it can list
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
    from rostether.cli.dashboard.served import DashboardSettings
    from rostether.cli.launch import listing
    from rostether.cli.launch.packages_here import packages_here
    from rostether.cli.launch.sources import find_sources
    from rostether.cli.shell.running import run
    from rostether.launch.bundled_packages import bundled_packages
    from rostether.launch.node_process import StopLimits
    from rostether.launch.plan import Output
    from rostether.launch.runner import RunOptions
    from rostether.packages.locate import package_around, package_folders

    if (
        sum(
            map(
                bool,
                (
                    options.lists_nodes,
                    options.dumps,
                    options.lists_arguments,
                    options.lists_files,
                    options.args_of,
                    options.file_of,
                ),
            )
        )
        > 1
    ):
        raise click.UsageError("give one of --nodes, --dump-params, --ros-args, --files, --args, --find-node")
    if options.screen and options.to_log:
        raise click.UsageError("give --screen or --log, not both")
    environment = read_environment(graph)
    packages = packages_here()
    packages = packages | {
        name: folder for name, folder in bundled_packages().items() if name not in packages
    }
    sources = find_sources(words, packages)
    for file in sources.files:
        # A package's file that is given by its path sees that package, and those beside it, as well.
        if (package := package_around(file.absolute().parent)) is not None:
            packages = package_folders({}, package) | packages
    near = _nearest(packages)
    environ = _environ_for(near)
    # Who asks what a file would do does not expect its programs to run; only the parameters need them.
    only_lists = options.lists_nodes or options.lists_arguments or options.lists_files
    runs_commands = not (only_lists or options.args_of is not None or options.file_of is not None)
    plan = _load(sources, packages, environ, runs_commands=runs_commands)
    locate = _locator(packages, near)
    if options.lists_nodes:
        _print(listing.node_lines(plan))
    elif options.dumps:
        write_line(listing.parameter_lines(plan))
    elif options.lists_arguments:
        _print(listing.argument_lines(plan))
    elif options.lists_files:
        _print(listing.file_lines(plan))
    elif options.args_of is not None:
        node = listing.find_node(plan, options.args_of, environment.namespace)
        write_line(listing.command_words(node, environ, environment.master_uri, locate))
    elif options.file_of is not None:
        write_line(listing.find_node(plan, options.file_of, environment.namespace).file)
    else:
        _warn(plan, sources)
        if not options.no_summary:
            _print(listing.summary_lines(plan))
        run_options = RunOptions(
            output=Output.SCREEN if options.screen else Output.LOG if options.to_log else None,
            all_required=options.required,
            stop_limits=StopLimits(options.sigint_timeout, options.sigterm_timeout),
        )
        if options.pid_file is not None:
            options.pid_file.write_text(f"{os.getpid()}\n")
        # Windows of rviz and rqt that are not installed are views of the dashboard.
        place = DEFAULT_PLACE if dashboard is None and _wants_views(plan) else dashboard
        try:
            run(
                _launch(
                    plan,
                    environment,
                    environ,
                    locate,
                    run_options,
                    is_chosen=graph.master is not None,
                    port=options.port,
                    wait=options.wait,
                    dashboard=DashboardSettings(place, gateways) if place is not None else None,
                ),
                is_service=True,
            )
        finally:
            if options.pid_file is not None:
                options.pid_file.unlink(missing_ok=True)


def _load(
    sources: LaunchSources, packages: Mapping[str, Path], environ: Mapping[str, str], *, runs_commands: bool
) -> LaunchPlan:
    from rostether.cli.access.graph_options import ros_arguments
    from rostether.cli.launch.served_nodes import served_nodes, served_programs
    from rostether.launch.loading import load_launch

    return load_launch(
        sources.files,
        {**sources.arguments, **ros_arguments()},
        environ,
        packages,
        text=read_bytes(STDIN) if sources.reads_stdin else None,
        programs=served_programs(),
        served_packages={package for package, _ in served_nodes()},
        runs_commands=runs_commands,
    )


def _locator(packages: Mapping[str, Path], near: Mapping[str, Path]) -> Locate:
    from rostether.cli.launch.node_command import node_command
    from rostether.cli.launch.served_nodes import replacement_line
    from rostether.launch.command_line import Program, Replaced
    from rostether.rospy.environment import node_environment

    def locate(package: str, node_type: str, environ: Mapping[str, str]) -> Program | Replaced:
        if line := replacement_line(package, environ):
            return Replaced(line)
        words = node_command(package, node_type, packages=packages, environ=environ)
        return Program(words, node_environment(environ, near))

    return locate


def _environ_for(packages: Mapping[str, Path]) -> dict[str, str]:
    """Return our environment, with all packages that we see: nodes start in another folder."""
    given = [part for part in os.environ.get(_PACKAGE_PATH, "").split(os.pathsep) if part]
    roots = [Path(part).absolute() for part in given]
    others = [each for each in packages.values() if not any(each.is_relative_to(root) for root in roots)]
    path = os.pathsep.join(map(str, (*roots, *others)))
    return {**os.environ, _PACKAGE_PATH: path} if path else dict(os.environ)


def _nearest(packages: Mapping[str, Path]) -> dict[str, Path]:
    """Return as many packages, the nearest first, as fit into a variable of the nodes' environment."""
    found: dict[str, Path] = {}
    length = 0
    for name, folder in packages.items():
        length += len(str(folder)) + 1
        if length > _MAX_PATH_CHARS:
            break
        found[name] = folder
    return found


def _wants_views(plan: LaunchPlan) -> bool:
    from rostether.cli.launch.served_nodes import replacement_line

    return any(replacement_line(node.package, os.environ) for node in plan.nodes)


def _warn(plan: LaunchPlan, sources: LaunchSources) -> None:
    for line in plan.warnings:
        warn(f"warning: {line}")
    for name in sources.arguments.keys() - plan.argument_names:
        warn(f"warning: the launch file declares no argument {name}; --ros-args shows the declared ones")
    for name in sources.empty_arguments:
        warn(f"warning: {name}:= has no value and is ignored, as with roslaunch")


async def _launch(  # noqa: PLR0913 - each is an independent setting
    plan: LaunchPlan,
    environment: RosEnvironment,
    environ: Mapping[str, str],
    locate: Locate,
    options: RunOptions,
    *,
    is_chosen: bool,
    port: int | None,
    wait: bool,
    dashboard: DashboardSettings | None,
) -> None:
    from dataclasses import replace

    from rostether.cli.access.master_choice import master_answers, used_master
    from rostether.cli.access.ros1_access import joining_ros1, no_master
    from rostether.cli.access.served_graphs import ServedGraphs
    from rostether.cli.dashboard.served import dashboard_beside
    from rostether.launch.runner import run_plan

    if wait and not await master_answers(environment):
        write_line(f"Waiting for the ROS master at {environment.master_uri}")
        while not await master_answers(environment):  # noqa: ASYNC110 - there is no event for a new master
            await asyncio.sleep(_WAIT_S)
    async with used_master(environment, is_chosen=is_chosen, port=port) as used:
        write_line(used.line)
        graphs = ServedGraphs(joining_ros1(used.environment), used.environment, ())
        try:
            async with dashboard_beside(dashboard, graphs, (), _report):
                succeeded = await run_plan(
                    plan,
                    master_uri=used.environment.master_uri,
                    environ=environ,
                    locate=locate,
                    report=_report,
                    options=replace(options, stays=used.is_ours or dashboard is not None),
                )
        except MasterUnreachableError as error:
            raise no_master(used.environment, error) from error
    if not succeeded:
        raise click.exceptions.Exit(1)


def _report(level: int, text: str) -> None:
    from rostether.cli.shell.failures import print_error
    from rostether.graph.ports import Level

    if level >= Level.ERROR:
        print_error(text)
    elif level >= Level.WARN:
        warn(f"warning: {text}")
    else:
        write_line(text)


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        write_line(line)
