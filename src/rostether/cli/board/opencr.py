"""`rostether board run --board opencr`: a sketch for the board of a TurtleBot3, on a simulated robot."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.board.console import handling_commands, show_event, show_start
from rostether.cli.shell.output import warn
from rostether.errors import BoardError, ConfigError, SketchError
from rostether.mechanisms.loop_thread import in_own_loop

if TYPE_CHECKING:
    from rostether.simulation.opencr.board import OpenCrBoard

OPENCR = "opencr"


async def start_opencr(
    sketch: Path,
    commands: Sequence[str],
    link_path: Path | None = None,
    msg_paths: Sequence[Path] = (),
    *,
    has_other_options: bool,
) -> OpenCrBoard:
    """Build a sketch and start it; the board gets `commands` at its start, and `link_path` leads to its port.

    Raises ConfigError for commands and options that the board does not have, FirmwareError if the sketch
    cannot be built, BoardError if it cannot be started.
    """
    from rostether.firmware.opencr_build import build_for_linux
    from rostether.simulation.opencr.board import OpenCrBoard
    from rostether.simulation.opencr.commands import execute

    if has_other_options:
        raise ConfigError(
            "the simulated OpenCR is a Linux program that runs in real time; omit --uart, --seed, --fast, "
            "--duration and --tcp"
        )
    try:
        # A build reads many files; meanwhile a bridge must serve its boards.
        program = await in_own_loop(lambda: build_for_linux(sketch, msg_paths))
    except SketchError as error:
        warn(error.diagnostics.rstrip())
        raise
    board = await OpenCrBoard.start(program, link_path=link_path)
    try:
        for line in commands:
            execute(board, line)
    except BaseException:
        await board.close()
        raise
    return board


async def run_opencr(
    sketch: Path,
    commands: Sequence[str],
    link_path: Path | None,
    msg_paths: Sequence[Path],
    *,
    has_other_options: bool,
    as_json: bool,
) -> None:
    """Run a sketch until it ends, with commands on standard input. Raises the errors of `start_opencr`."""
    from rostether.simulation.opencr.commands import execute

    board = await start_opencr(sketch, commands, link_path, msg_paths, has_other_options=has_other_options)

    async def execute_line(line: str) -> None:
        answer = execute(board, line)
        if answer is not None:
            show_event(answer, as_json=as_json)

    async with board:
        board.on_event = partial(show_event, as_json=as_json)
        title = "" if as_json else f"{OPENCR} (Linux program)"
        show_start(title, OPENCR, sketch, board.address, link_path)
        async with handling_commands(execute_line):
            await board.wait_end()
    raise BoardError(f"the simulated board has ended: {board.exit_message or 'no reason given'}")
