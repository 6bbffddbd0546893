"""`rostether launch`: runs launch files, like roslaunch."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
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
from rostether.cli.shell.completion import beginning
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED, print_error
from rostether.cli.shell.option_group import FILE, PORT, POSITIVE, flag, ignored_options, option, option_group
from rostether.cli.shell.output import warn, write_file, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import MasterUnreachableError
from rostether.graph.ports import Level
from rostether.launch import listing
from rostether.launch.plan import Output
from rostether.launch.sources import launch_files
from rostether.packages.locate import package_folders

if TYPE_CHECKING:
    from rostether.cli.dashboard.settings import DashboardSettings
    from rostether.cli.launch.loaded_launch import LoadedLaunch
    from rostether.ros1.environment import RosEnvironment


# Options of roslaunch that scripts use; they have no effect here.
roslaunch_options = ignored_options(
    "-w --numworkers",
    "-t --timeout",
    "--master-logger-level",
    flags=["--local", "--skip-log-check", "--disable-title", "-v --verbose"],
)


@dataclass(frozen=True, slots=True)
class LaunchOptions:
    """The options of `launch`."""

    lists_nodes: bool = flag("--nodes", "Only print the names of the nodes.")
    dumps: bool = flag("--dump-params", "Only print the parameters, as YAML.")
    lists_arguments: bool = flag("--ros-args", "Print the arguments of the launch file.")
    lists_files: bool = flag("--files", "Print the file and all files that it includes.")
    args_of: str | None = option("--args NODE", "Print the command line of a node.")
    file_of: str | None = option("--find-node NODE", "Print the file that defines a node.")
    screen: bool = flag("--screen", "Show the output of all nodes.")
    to_log: bool = flag("--log", "Write the output of all nodes to their log files.")
    required: bool = flag("--required", "Stop all nodes when any of them ends.")
    wait: bool = flag("--wait", "Wait for a master instead of starting one.")
    port: int | None = option(
        "-p --port",
        "Port for the ROS master, which is started if none runs (default: that of ROS_MASTER_URI, or 11311).",
        type=PORT,
    )
    no_summary: bool = flag("--no-summary", "Do not print the summary.")
    sigint_timeout_s: float = option(
        "--sigint-timeout S",
        "The time limit, in seconds, for a node to end after SIGINT (default: 15).",
        type=POSITIVE,
        default=15.0,
    )
    sigterm_timeout_s: float = option(
        "--sigterm-timeout S",
        "The time limit, in seconds, for a node to end after SIGTERM (default: 2).",
        type=POSITIVE,
        default=2.0,
    )
    pid_file: Path | None = option("--pid", "Write the process id of this command to a file.", type=FILE)

    def check(self) -> None:
        """Check that the options go together. Raises click.UsageError."""
        listings = (
            self.lists_nodes,
            self.dumps,
            self.lists_arguments,
            self.lists_files,
            self.args_of,
            self.file_of,
        )
        if sum(map(bool, listings)) > 1:
            raise click.UsageError(
                "give one of --nodes, --dump-params, --ros-args, --files, --args, --find-node"
            )
        if self.screen and self.to_log:
            raise click.UsageError("give --screen or --log, not both")

    @property
    def runs_commands(self) -> bool:
        """Whether to run the programs that compute parameters; most listings do not show parameters."""
        only_lists = self.lists_nodes or self.lists_arguments or self.lists_files
        return not (only_lists or self.args_of is not None or self.file_of is not None)


def complete_launch(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return packages with launch files; after a package, its launch files."""
    packages = package_folders(os.environ, Path.cwd())
    words = ctx.params.get("words") or ()
    if words and words[0] in packages:
        return beginning(launch_files(packages[words[0]]), incomplete)
    return beginning((name for name, folder in packages.items() if launch_files(folder)), incomplete)


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
) -> int:
    """Set the parameters and start the nodes of launch files; start a master if none runs.

    Packages are found on ROS_PACKAGE_PATH, in the catkin workspace around this folder, and below it; nothing
    needs to be built. Logs are kept in ~/.ros/log/latest. Ctrl-C ends all nodes cleanly.
    """
    from rostether.cli.access.ros1_access import read_environment
    from rostether.cli.dashboard.settings import DashboardSettings
    from rostether.cli.launch.loaded_launch import load
    from rostether.cli.shell.running import run

    options.check()
    environment = read_environment(graph)
    loaded = load(words, runs_commands=options.runs_commands)
    if (lines := _listing(options, loaded, environment)) is not None:
        _print(lines)
        return EXIT_DONE
    loaded.warn()
    if not options.no_summary:
        _print(listing.summary_lines(loaded.plan))
    views = tuple(loaded.views)
    address = DEFAULT_ADDRESS if dashboard is None and views else dashboard
    settings = DashboardSettings(address, gateways, views=views) if address is not None else None
    is_chosen = graph.master is not None
    with _written_pid(options.pid_file):
        return run(_run(loaded, options, environment, settings, is_chosen=is_chosen), is_service=True)


async def _run(
    loaded: LoadedLaunch,
    options: LaunchOptions,
    environment: RosEnvironment,
    dashboard: DashboardSettings | None,
    *,
    is_chosen: bool,
) -> int:
    """Run the nodes until all have ended; return the exit code. `is_chosen`: an option named the master."""
    from rostether.cli.access.ros1_access import no_master, ros1_join
    from rostether.cli.access.served_graphs import ServedGraphs, master_answers, used_master, wait_for_answer
    from rostether.cli.dashboard.optional import optional_dashboard
    from rostether.cli.dashboard.view import has_browser, open_browser
    from rostether.launch.node_process import StopLimits
    from rostether.launch.runner import RunOptions, run_plan

    if options.wait and not await master_answers(environment):
        write_line(f"Waiting for the ROS master at {environment.master_uri}")
        await wait_for_answer(environment)
    async with used_master(environment, is_chosen=is_chosen, port=options.port) as used:
        write_line(used.line)
        graphs = ServedGraphs(ros1_join(used.environment), used.environment, ())
        try:
            async with optional_dashboard(dashboard, graphs, loaded.package_folders, _report) as served:
                if served is not None and has_browser(os.environ):
                    for url in served.view_urls:
                        await open_browser(url)
                succeeded = await run_plan(
                    loaded.plan,
                    master_uri=used.environment.master_uri,
                    environ=loaded.environ,
                    locate=loaded.locate,
                    report=_report,
                    options=RunOptions(
                        output=Output.SCREEN if options.screen else Output.LOG if options.to_log else None,
                        all_required=options.required,
                        stop_limits=StopLimits(options.sigint_timeout_s, options.sigterm_timeout_s),
                        stays=used.is_started_here or dashboard is not None,
                    ),
                )
        except MasterUnreachableError as error:
            raise no_master(used.environment, error) from error
    return EXIT_DONE if succeeded else EXIT_FAILED


def _listing(options: LaunchOptions, loaded: LoadedLaunch, environment: RosEnvironment) -> list[str] | None:
    from rostether.param_yaml import dump

    plan = loaded.plan
    if options.lists_nodes:
        return listing.node_lines(plan)
    if options.dumps:
        return [dump(plan.parameters)]
    if options.lists_arguments:
        return list(listing.argument_lines(plan))
    if options.lists_files:
        return listing.file_lines(plan)
    if options.args_of is not None:
        node = listing.find_node(plan, options.args_of, environment.namespace)
        return [listing.shell_line(node, loaded.environ, environment.master_uri, loaded.locate)]
    if options.file_of is not None:
        return [listing.find_node(plan, options.file_of, environment.namespace).file]
    return None


@contextmanager
def _written_pid(file: Path | None) -> Iterator[None]:
    if file is None:
        yield
        return
    write_file(file, f"{os.getpid()}\n")
    try:
        yield
    finally:
        file.unlink(missing_ok=True)


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        write_line(line)


def _report(level: int, text: str) -> None:
    if level >= Level.ERROR:
        print_error(text)
    elif level >= Level.WARN:
        warn(f"WARNING: {text}")
    else:
        write_line(text)
