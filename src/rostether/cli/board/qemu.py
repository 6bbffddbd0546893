"""`rostether board run --board netduinoplus2`: a program for a Cortex-M on a board that qemu simulates."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

from rostether.cli.board.console import handling_commands, show_start
from rostether.cli.shell.output import warn
from rostether.errors import BoardError, ConfigError, FirmwareError, SketchError
from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
from rostether.mechanisms.loop_thread import in_own_loop
from rostether.simulation.qemu import MACHINES, QemuBoard
from rostether.transports.address import ProgramSize

_PROGRAM_SUFFIXES = (".elf", ".hex")


async def start_in_qemu(
    program: Path, machine: str, link_path: Path | None = None, *, has_other_options: bool
) -> QemuBoard:
    """Start a board with an ELF file as its program; `link_path` leads to its port.

    Raises ConfigError for other files and for options of other boards, BoardError if it cannot be started.
    """
    if has_other_options:
        raise ConfigError(
            f"{machine} is simulated without pins and devices; it does not accept the commands and options "
            "of other boards"
        )
    if program.suffix.lower() != ".elf":
        raise ConfigError(f"{machine} runs only ELF files; compile {program} with arm-none-eabi-g++ first")
    _refuse_missing(program)
    return await QemuBoard.start(program, machine=machine, link_path=link_path)


async def run_in_qemu(
    program: Path, machine: str, link_path: Path | None, *, has_other_options: bool, as_json: bool
) -> None:
    """Run an ELF file until it ends; its only command on standard input is `reset`.

    Raises the same errors as `start_in_qemu`.
    """
    async with await start_in_qemu(program, machine, link_path, has_other_options=has_other_options) as board:
        core, _ = MACHINES[machine]
        show_start("" if as_json else f"{machine} ({core})", machine, program, board.address, link_path)

        async def execute(line: str) -> None:
            if line.split() != ["reset"]:
                raise BoardError(
                    f"{line.strip()!r} is not a command of this board; its only command is reset"
                )
            await board.reset()

        async with handling_commands(execute):
            await board.wait_end()
    raise BoardError(f"qemu has ended: {board.exit_message or 'no reason given'}")


async def find_program(path: Path, board: str, msg_paths: Sequence[Path] = ()) -> Path:
    """Return the program for a board; a sketch is built first.

    Raises BoardError if there is no such file, FirmwareError if the sketch cannot be built.
    """
    if path.suffix.lower() in _PROGRAM_SUFFIXES:
        _refuse_missing(path)
        return path
    from rostether.firmware.build import build_sketch, find_board

    async def build() -> BuiltFirmware:
        _refuse_missing(path)
        return await build_sketch(path, find_board(board), BuildOptions(msg_paths=tuple(msg_paths)))

    try:
        # A build searches folders of libraries and definitions; meanwhile a bridge must serve its boards.
        built = await in_own_loop(build)
    except SketchError as error:
        warn(error.diagnostics.rstrip())
        raise
    return built.elf


def _refuse_missing(path: Path) -> None:
    if not path.exists():
        raise BoardError(f"{path} does not exist; give a sketch, a folder with one, or an ELF or HEX file")


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
