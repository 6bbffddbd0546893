"""`rostether firmware build`, `upload` and `sim`, and `rostether flash`: sketches, flashed or simulated."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.completions import complete_ports
from rostether.cli.board.run import OLD_OPTIONS, board_run
from rostether.cli.firmware.options import SketchOptions, build, sketch_options
from rostether.cli.shell.option_group import PATH, add_option
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.own_command import own_command, replace_process
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.errors import FirmwareError
from rostether.firmware.build import find_board, save_outputs
from rostether.firmware.built_firmware import BuiltFirmware
from rostether.firmware.sketch import open_sketch
from rostether.firmware.upload import prepare_upload, upload

if TYPE_CHECKING:
    from rostether.firmware.elf import ElfFile

# The build's own options cover these.
_BUILD_OPTIONS = frozenset(("program", "board", "msg_paths"))
# The baud rate that a sketch sets.
_BAUD = re.compile(r"\bsetBaud\s*\(\s*([0-9]+)\s*\)")

_port_option = add_option(
    "-p --port PORT", "The board's serial port (default: the only one found).", shell_complete=complete_ports
)


@verb(
    "build",
    """
    rostether firmware build blink.ino                          for an Uno
    rostether firmware build Blink --board mega --output out    writes out/Blink.elf and out/Blink.hex
    rostether firmware build robot --msg-path ~/my_robot --library ~/libs/Encoder
    rostether firmware build robot --board esp32:esp32:esp32    with arduino-cli
    """,
)
@sketch_options
@add_option(
    "-o --output folder DIR", "Copy the ELF and HEX files there (default: they stay in the cache).", type=PATH
)
@json_option
async def firmware_build(options: SketchOptions, folder: Path | None, as_json: bool) -> None:
    """Build a sketch: an .ino file, a folder with one, or a .cpp file.

    The included headers select the libraries, from --library, the ROS library (generated for this sketch),
    the Arduino sketchbook, the core (Wire, SPI, EEPROM, SoftwareSerial) and a built-in Servo. Unchanged files
    are not compiled again. Needs Debian's gcc-avr, avr-libc and arduino-core-avr, or arduino-cli.
    """
    from rostether.firmware.elf import ElfFile

    built = await build(options)
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
@sketch_options
@_port_option
async def firmware_upload(options: SketchOptions, port: str | None) -> None:
    """Build a sketch and flash it with avrdude (or arduino-cli).

    A sketch that does not fit is not flashed. If only the stack may be too large, the command prints a
    warning first.
    """
    await upload_sketch(options, port)


async def upload_sketch(options: SketchOptions, port: str | None) -> str:
    """Build and flash a sketch; return the port of the board.

    Raises the errors of `build`, and TransportOpenError if the port cannot be used.
    """
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.footprint import measure_built

    open_sketch(options.sketch)
    how = options.build_options()
    # The port is checked first, because a build may take half a minute.
    chosen = await prepare_upload(find_board(options.board), port, uses_arduino_cli=how.uses_arduino_cli)
    built = await build(options)
    elf = ElfFile.read(built.elf)
    await refuse_too_large(built, elf)
    for line in (await measure_built(built)).warnings():
        warn(f"WARNING: {line}")
    write_line(f"flashing {built.board.title} on {chosen}: {describe_sizes(built, elf)}")
    await upload(built, chosen, uses_arduino_cli=how.uses_arduino_cli, show=how.show)
    write_line("done; the board now runs the sketch")
    return chosen


@verb(
    "sim",
    """
    rostether firmware sim blink.ino --watch D13
    rostether firmware sim robot --board mega --library ~/libs/Encoder --link /tmp/board
    """,
    is_service=True,
    old_options=OLD_OPTIONS,
)
@sketch_options
@click.pass_context
async def firmware_sim(context: click.Context, /, options: SketchOptions, **board_options: Any) -> None:
    """Build a sketch and run it on a simulated board.

    The options, commands and events are those of `rostether board run`, which also runs
    programs that are already built.
    """
    built = await build(options)
    await context.invoke(board_run, program=built.elf, board=options.board, msg_paths=(), **board_options)


firmware_sim.params += [each for each in board_run.params if each.name not in _BUILD_OPTIONS]


@verb(
    "flash",
    """
    rostether flash ultrasound                     to the only board plugged in
    rostether flash robot --board mega --port /dev/ttyACM0
    """,
)
@sketch_options
@_port_option
def flash(options: SketchOptions, port: str | None) -> None:
    """Build a sketch, flash it, and connect the board to the ROS graph until Ctrl-C.

    It combines `rostether firmware upload` and `rostether serve`; the log shows the board's topics.
    """
    address = _address_of(options.sketch, run(upload_sketch(options, port)))
    write_line(f"rostether serve {shlex.quote(address)}")
    replace_process(own_command("serve", address), os.environ)


def _address_of(sketch: Path, port: str) -> str:
    """Return the link address of a port, with the baud rate that the sketch sets."""
    found = open_sketch(sketch)
    for file in (*found.inos, *found.sources):
        if match := _BAUD.search(file.read_text(encoding="utf-8", errors="replace")):
            return f"{port}?baud={match[1]}"
    return port
