"""The options of `rostether launch`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.shell.option_group import ignored_options, option_group

_SECONDS = click.FloatRange(0, min_open=True)

# Options of roslaunch that scripts use; they have no effect here.
roslaunch_options = ignored_options(
    "-w --numworkers",
    "-t --timeout",
    "--master-logger-level",
    local="--local",
    log_check="--skip-log-check",
    title="--disable-title",
    verbose="-v --verbose",
)


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
        """Whether to run the programs that compute parameters; only some listings need them."""
        only_lists = self.lists_nodes or self.lists_arguments or self.lists_files
        return not (only_lists or self.args_of is not None or self.file_of is not None)


launch_options = option_group(
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
