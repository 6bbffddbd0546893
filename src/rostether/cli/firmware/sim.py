"""`rostether firmware sim`: `board run` with the options of a build."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.board.run import OLD_OPTIONS, board_run
from rostether.cli.firmware.options import build, build_options
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb

if TYPE_CHECKING:
    from rostether.firmware.build import BuildOptions

# The build's own options cover these.
_OURS = frozenset(("program", "board", "msg_paths"))


@click.command(
    "sim",
    cls=Verb,
    old_options=OLD_OPTIONS,
    examples="""
    rostether firmware sim blink.ino --watch D13
    rostether firmware sim robot --board mega --library ~/libs/Encoder --link /tmp/board
    """,
)
@build_options
@click.pass_context
def firmware_sim(
    context: click.Context, /, sketch: Path, board_name: str, options: BuildOptions, **of_the_board: Any
) -> None:
    """Build a sketch and run it on a simulated board.

    The options, commands and events are those of `rostether board run`, which runs a program that is already
    built.
    """
    built = run(build(sketch, board_name, options))
    context.invoke(board_run, program=built.elf, board=board_name, msg_paths=(), **of_the_board)


firmware_sim.params += [each for each in board_run.params if each.name not in _OURS]
