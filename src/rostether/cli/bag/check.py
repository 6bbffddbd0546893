"""`rostether bag check`: reads a whole recording and lists its errors."""

from __future__ import annotations

from pathlib import Path

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import PATH
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import counted


@verb(
    "check",
    """
    rostether bag check drive.bag
    rostether bag check drive.bag --msg-path ~/catkin_ws/src
    """,
)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=PATH)
@msg_path_option
def bag_check(files: tuple[Path, ...], msg_paths: tuple[Path, ...]) -> int:
    """Read every message and report errors; the exit code is 1 if there are any.

    The command checks that the index is complete, that every message fits its definition in the file, and
    that this definition equals the one that rostether finds.
    """
    from rostether.msgdef.registry import Registry
    from rostether.recording.checking import check

    registry = Registry.from_environment(msg_paths)
    has_errors = False
    for path in files:
        checked = check(path, registry)
        for fault in checked.faults:
            write_line(f"{path}: {fault}")
        if not checked.faults:
            write_line(f"{path}: {counted(checked.message_count, 'message')}, no errors")
        has_errors = has_errors or bool(checked.faults)
    return EXIT_FAILED if has_errors else EXIT_DONE
