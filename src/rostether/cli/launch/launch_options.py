"""The options of `rostether launch`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.shell.option_group import FILE, PORT, POSITIVE, flag, ignored_options, option

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
        "-p --port", "Port for the ROS master, which is started if none runs (11311).", type=PORT
    )
    no_summary: bool = flag("--no-summary", "Do not print the summary.")
    sigint_timeout: float = option(
        "--sigint-timeout S", "Seconds that a node has to end after SIGINT (15).", type=POSITIVE, default=15.0
    )
    sigterm_timeout: float = option(
        "--sigterm-timeout S", "Seconds that a node has to end after SIGTERM (2).", type=POSITIVE, default=2.0
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
        """Whether to run the programs that compute parameters; only some listings need them."""
        only_lists = self.lists_nodes or self.lists_arguments or self.lists_files
        return not (only_lists or self.args_of is not None or self.file_of is not None)
