"""`rostether firmware upload`: flashes a sketch to a real board."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.firmware.build import describe_sizes, refuse_too_large
from rostether.cli.firmware.options import build, build_options
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb

if TYPE_CHECKING:
    from rostether.firmware.build import BuildOptions


@click.command(
    "upload",
    cls=Verb,
    examples="""
    rostether firmware upload blink.ino                            to the only board plugged in
    rostether firmware upload robot --board mega --port /dev/ttyACM0
    rostether firmware upload robot --board nano:atmega328old      a Nano with the old boot loader
    """,
)
@build_options
@click.option("-p", "--port", metavar="PORT", help="The board's serial port (default: the only one found).")
def firmware_upload(sketch: Path, board_name: str, options: BuildOptions, port: str | None) -> None:
    """Build a sketch and flash it with avrdude (or arduino-cli).

    A sketch that does not fit is not flashed. If only the stack may be too large, the command prints a
    warning first.
    """
    run(upload_sketch(sketch, board_name, options, port))


async def upload_sketch(sketch: Path, board_name: str, options: BuildOptions, port: str | None) -> str:
    """Build and flash a sketch; returns the port of the board. Raises FirmwareError, ConfigError."""
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.footprint import measure_built
    from rostether.firmware.upload import choose_port, upload

    built = await build(sketch, board_name, options)
    elf = ElfFile.read(built.elf)
    await refuse_too_large(built, elf)
    for line in (await measure_built(built)).warnings():
        warn(f"WARNING: {line}")
    chosen = choose_port(built.board) if port is None else port
    write_line(f"flashing {built.board.title} on {chosen}: {describe_sizes(built, elf)}")
    await upload(built, chosen, uses_arduino_cli=options.uses_arduino_cli, show=options.show)
    write_line("done; the board now runs the sketch")
    return chosen
