"""The program of a simulated board: an ELF or HEX file, or a sketch, which is built first."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

from rostether.cli.shell.output import warn
from rostether.errors import BoardError, ConfigError, FirmwareError, SketchError
from rostether.mechanisms.own_loop import in_own_loop
from rostether.transports.address import ProgramSize

_PROGRAM_SUFFIXES = (".elf", ".hex")


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
    """Return what a program takes of a board's memory; None unless it is an ELF file. Reads the disk."""
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
        # The simulator reports what is wrong with it.
        return None
    return ProgramSize(program.flash_bytes, flash_limit_bytes, program.ram_bytes, ram_limit_bytes)
