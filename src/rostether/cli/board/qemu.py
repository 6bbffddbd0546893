"""`rostether board run --board netduinoplus2`: a program for a Cortex-M on a board that qemu simulates."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rostether.cli.shell.input import input_lines
from rostether.cli.shell.output import warn, write_json, write_line
from rostether.errors import BoardError, ConfigError, FirmwareError, SketchError
from rostether.mechanisms.own_loop import in_own_loop
from rostether.simulation.qemu import MACHINES
from rostether.transports.address import ProgramSize

if TYPE_CHECKING:
    from rostether.simulation.qemu import QemuBoard

_PROGRAM_SUFFIXES = (".elf", ".hex")


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

    Raises the same errors as `start_in_qemu`.
    """
    async with await start_in_qemu(program, machine, link_path, has_words=has_words) as board:
        if as_json:
            write_json({"event": "ready", "board": machine, "link": board.address})
        else:
            linked = f", linked at {link_path}" if link_path else ""
            core, _ = MACHINES[machine]
            write_line(f"{machine} ({core}) runs {program}; serial port {board.address}{linked}")
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


async def find_program(path: Path, board: str, msg_paths: Sequence[Path] = ()) -> Path:
    """Return the program for a board. Raises BoardError if there is no such file, and build errors."""
    if path.suffix.lower() in _PROGRAM_SUFFIXES:
        return path
    if not path.exists():  # noqa: ASYNC240 - one look
        raise BoardError(f"{path} does not exist; give a sketch, a folder with one, or an ELF or HEX file")
    from rostether.firmware.build import BuildOptions, BuiltFirmware, build_sketch, find_board

    async def build() -> BuiltFirmware:
        return await build_sketch(path, find_board(board), BuildOptions(msg_paths=tuple(msg_paths)))

    try:
        # A build searches folders of libraries and definitions; meanwhile a bridge must serve its boards.
        built = await in_own_loop(build)
    except SketchError as error:
        warn(error.diagnostics.rstrip())
        raise
    return built.elf


def measure_program(path: Path, board: str) -> ProgramSize | None:
    """Return the memory use of a program on a board; None unless it is an ELF file. Reads the disk."""
    from rostether.firmware.build import find_board
    from rostether.firmware.elf import ElfFile

    if path.suffix.lower() != ".elf":
        return None
    flash_limit_bytes = ram_limit_bytes = 0
    # Without a toolchain, the sizes of the board's memory are not known.
    with contextlib.suppress(ConfigError, FirmwareError):
        memory = find_board(board)
        flash_limit_bytes, ram_limit_bytes = memory.flash_bytes, memory.ram_bytes
    try:
        program = ElfFile.read(path)
    except FirmwareError:
        # The simulator reports the problem of the file.
        return None
    return ProgramSize(program.flash_bytes, flash_limit_bytes, program.ram_bytes, ram_limit_bytes)
