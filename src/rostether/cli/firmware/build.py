"""`rostether firmware build`, `upload` and `sim`: build a sketch, flash it, or run it simulated."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.board.run import OLD_OPTIONS, board_run
from rostether.cli.firmware.options import build, build_options, port_option
from rostether.cli.shell.option_group import PATH, add_option
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.errors import FirmwareError

if TYPE_CHECKING:
    from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
    from rostether.firmware.elf import ElfFile

# The build's own options cover these.
_BUILD_OPTIONS = frozenset(("program", "board", "msg_paths"))


@verb(
    "build",
    """
    rostether firmware build blink.ino                          for an Uno
    rostether firmware build Blink --board mega --output out    writes out/Blink.elf and out/Blink.hex
    rostether firmware build robot --msg-path ~/my_robot --library ~/libs/Encoder
    rostether firmware build robot --board esp32:esp32:esp32    with arduino-cli
    """,
)
@build_options
@add_option(
    "-o --output folder DIR", "Copy the ELF and HEX files there (default: they stay in the cache).", type=PATH
)
@json_option
def firmware_build(
    sketch: Path, board_name: str, options: BuildOptions, folder: Path | None, as_json: bool
) -> None:
    """Build a sketch: an .ino file, a folder with one, or a .cpp file.

    The included headers select the libraries, from --library, the ROS library (generated for this sketch),
    the Arduino sketchbook, the core (Wire, SPI, EEPROM, SoftwareSerial) and a built-in Servo. Unchanged files
    are not compiled again. Needs Debian's gcc-avr, avr-libc and arduino-core-avr, or arduino-cli.
    """
    run(_build(sketch, board_name, options, folder, as_json))


async def _build(
    sketch: Path, board_name: str, options: BuildOptions, folder: Path | None, as_json: bool
) -> None:
    from rostether.firmware.build import save_outputs
    from rostether.firmware.elf import ElfFile

    built = await build(sketch, board_name, options)
    elf = ElfFile.read(built.elf)
    await refuse_too_large(built, elf)
    paths = save_outputs(built, folder) if folder is not None else (built.elf, built.image)
    if as_json:
        write_json(_record(built, elf, paths))
        return
    write_line(f"{built.sketch.name} for {built.board.title}: {describe_sizes(built, elf)}")
    write_line(f"  {_shown(paths[1])}")


async def refuse_too_large(built: BuiltFirmware, elf: ElfFile) -> None:
    """Raise FirmwareError if the program does not fit the board, with its largest part."""
    board = built.board
    fits_flash = not board.flash_bytes or elf.flash_bytes <= board.flash_bytes
    fits_ram = not board.ram_bytes or elf.ram_bytes <= board.ram_bytes
    if fits_flash and fits_ram:
        return
    from rostether.firmware.footprint import measure_built

    footprint = await measure_built(built)
    raise FirmwareError(f"{footprint.refusals()[0]}; see `rostether firmware size`")


def describe_sizes(built: BuiltFirmware, elf: ElfFile) -> str:
    """Return flash and RAM with their limits, if known."""
    flash = _used_of(elf.flash_bytes, built.board.flash_bytes)
    return f"{flash} of flash, {_used_of(elf.ram_bytes, built.board.ram_bytes)} of RAM"


def _used_of(used: int, limit: int) -> str:
    if not limit:
        return f"{used} bytes"
    return f"{used} of {limit} bytes ({100 * used / limit:.0f} %)"


def _shown(path: Path) -> str:
    relative = os.path.relpath(path)
    return str(path) if relative.startswith("..") else relative


def _record(built: BuiltFirmware, elf: ElfFile, paths: tuple[Path, Path]) -> dict[str, object]:
    return {
        "sketch": built.sketch.name,
        "board": built.board.fqbn,
        "elf": str(paths[0]),
        "image": str(paths[1]),
        "flash_bytes": elf.flash_bytes,
        "flash_limit_bytes": built.board.flash_bytes or None,
        "ram_bytes": elf.ram_bytes,
        "ram_limit_bytes": built.board.ram_bytes or None,
        "libraries": [{"name": each.name, "folder": str(each.folder)} for each in built.libraries],
        "duration_s": round(built.duration_s, 3),
        "is_from_cache": built.is_from_cache,
    }


@verb(
    "upload",
    """
    rostether firmware upload blink.ino                            to the only board plugged in
    rostether firmware upload robot --board mega --port /dev/ttyACM0
    rostether firmware upload robot --board nano:atmega328old      a Nano with the old bootloader
    """,
)
@build_options
@port_option
def firmware_upload(sketch: Path, board_name: str, options: BuildOptions, port: str | None) -> None:
    """Build a sketch and flash it with avrdude (or arduino-cli).

    A sketch that does not fit is not flashed. If only the stack may be too large, the command prints a
    warning first.
    """
    run(upload_sketch(sketch, board_name, options, port))


async def upload_sketch(sketch: Path, board_name: str, options: BuildOptions, port: str | None) -> str:
    """Build and flash a sketch; return the port of the board. Raises FirmwareError, ConfigError."""
    from rostether.firmware.build import find_board
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.footprint import measure_built
    from rostether.firmware.sketch import open_sketch
    from rostether.firmware.upload import prepare_upload, upload

    open_sketch(sketch)
    # The port is checked first, because a build may take half a minute.
    chosen = await prepare_upload(find_board(board_name), port, uses_arduino_cli=options.uses_arduino_cli)
    built = await build(sketch, board_name, options)
    elf = ElfFile.read(built.elf)
    await refuse_too_large(built, elf)
    for line in (await measure_built(built)).warnings():
        warn(f"WARNING: {line}")
    write_line(f"flashing {built.board.title} on {chosen}: {describe_sizes(built, elf)}")
    await upload(built, chosen, uses_arduino_cli=options.uses_arduino_cli, show=options.show)
    write_line("done; the board now runs the sketch")
    return chosen


@verb(
    "sim",
    """
    rostether firmware sim blink.ino --watch D13
    rostether firmware sim robot --board mega --library ~/libs/Encoder --link /tmp/board
    """,
    old_options=OLD_OPTIONS,
)
@build_options
@click.pass_context
def firmware_sim(
    context: click.Context, /, sketch: Path, board_name: str, options: BuildOptions, **board_options: Any
) -> None:
    """Build a sketch and run it on a simulated board.

    The options, commands and events are those of `rostether board run`, which also runs
    programs that are already built.
    """
    built = run(build(sketch, board_name, options))
    context.invoke(board_run, program=built.elf, board=board_name, msg_paths=(), **board_options)


firmware_sim.params += [each for each in board_run.params if each.name not in _BUILD_OPTIONS]
