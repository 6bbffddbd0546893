"""`rostether board run --board opencr`: a sketch for the board of a TurtleBot3, on a simulated robot."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.shell.input import input_lines
from rostether.cli.shell.output import warn, write_json, write_line
from rostether.errors import BoardError, ConfigError, SketchError

if TYPE_CHECKING:
    from rostether.simulation.opencr.board import OpenCrBoard
    from rostether.simulation.simavr.board_events import BoardEvent

OPENCR = "opencr"


async def start_opencr(
    sketch: Path,
    words: Sequence[str],
    link_path: Path | None = None,
    msg_paths: Sequence[Path] = (),
    *,
    has_other_options: bool,
) -> OpenCrBoard:
    """Build a sketch and start it. The board gets `words` at its start.

    Raises ConfigError for words that the board does not have, FirmwareError for a sketch that cannot be
    built, BoardError.
    """
    from rostether.firmware.opencr_build import build_for_linux
    from rostether.mechanisms.own_loop import in_own_loop
    from rostether.simulation.opencr.board import OpenCrBoard
    from rostether.simulation.opencr.words import obey

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
        for line in words:
            obey(board, line)
    except BaseException:
        await board.close()
        raise
    return board


async def run_opencr(
    sketch: Path,
    words: Sequence[str],
    link_path: Path | None,
    msg_paths: Sequence[Path],
    *,
    has_other_options: bool,
    as_json: bool,
) -> None:
    """Run a sketch until it ends, with words on standard input. Raises the same errors as `start_opencr`."""
    board = await start_opencr(sketch, words, link_path, msg_paths, has_other_options=has_other_options)
    async with board:
        board.on_event = _show_json if as_json else _show
        if as_json:
            write_json({"event": "ready", "board": OPENCR, "link": board.address})
        else:
            linked = f", linked at {link_path}" if link_path else ""
            write_line(f"{OPENCR} (Linux program) runs {sketch}; serial port {board.address}{linked}")
        listening = asyncio.get_running_loop().create_task(_listen(board))
        try:
            await board.wait_end()
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
    raise BoardError(f"the simulated board has ended: {board.last_words or 'no reason given'}")


async def _listen(board: OpenCrBoard) -> None:
    from rostether.simulation.opencr.words import obey

    async for line in input_lines():
        if not line.strip():
            continue
        try:
            answer = obey(board, line)
        except ConfigError as error:
            warn(f"rostether: error: {error}")
            continue
        if answer is not None and board.on_event is not None:
            board.on_event(answer)


def _show(event: BoardEvent) -> None:
    from rostether.simulation.simavr.board_events import show_event

    write_line(show_event(event))


def _show_json(event: BoardEvent) -> None:
    write_json({"event": event.name, "time_s": event.time_s, **event.values})
