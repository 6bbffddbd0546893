"""`rostether board run --board lm3s6965evb`: a program for a Cortex-M on a board that qemu simulates."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.shell.input_lines import input_lines
from rostether.cli.shell.output import warn, write_json, write_line
from rostether.errors import BoardError, ConfigError

if TYPE_CHECKING:
    from rostether.simulation.qemu import QemuBoard


# Boards with a Cortex-M, which qemu simulates.
MACHINES = ("lm3s6965evb",)


async def start_in_qemu(
    program: Path, machine: str, link_path: Path | None = None, *, has_words: bool
) -> QemuBoard:
    """Start an ELF file. Raises ConfigError for other files and for options of other boards, BoardError."""
    from rostether.simulation.qemu import QemuBoard

    if has_words:
        raise ConfigError(
            f"{machine} is simulated without pins and devices; it does not accept the commands and options "
            f"of other boards"
        )
    if program.suffix.lower() != ".elf":
        raise ConfigError(f"{machine} runs only ELF files; compile {program} with arm-none-eabi-g++ first")
    return await QemuBoard.start(program, machine=machine, link_path=link_path)


async def run_in_qemu(
    program: Path, machine: str, link_path: Path | None, *, has_words: bool, as_json: bool
) -> None:
    """Run an ELF file until it ends; its only command on standard input is `reset`.

    Raises as `start_in_qemu`.
    """
    async with await start_in_qemu(program, machine, link_path, has_words=has_words) as board:
        if as_json:
            write_json({"event": "ready", "board": machine, "link": board.address})
        else:
            linked = f", linked at {link_path}" if link_path else ""
            write_line(f"{machine} (Cortex-M3) runs {program}; serial port {board.address}{linked}")
        listening = asyncio.get_running_loop().create_task(_listen(board))
        try:
            await board.wait_end()
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
    raise BoardError(f"qemu has ended: {board.last_words or 'no reason given'}")


async def _listen(board: QemuBoard) -> None:
    async for line in input_lines():
        if line.split() == ["reset"]:
            await board.reset()
        elif line.strip():
            warn(
                f"rostether: error: {line.strip()!r} is not a command of this board; its only command is "
                f"reset"
            )
