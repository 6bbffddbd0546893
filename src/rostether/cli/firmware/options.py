"""The common part of the commands that build a sketch: their options, and running a build."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.option_group import PATH, argument, flag, option, option_group, shared
from rostether.cli.shell.output import warn
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.errors import FirmwareError, SketchError
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
from rostether.firmware.toolchain import find_avr_toolchain

ARDUINO_CLI = "arduino-cli"
AVR_GCC = "avr-gcc"


def complete_boards(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the boards that begin with the typed text."""
    try:
        names = find_avr_toolchain().boards.names
    except FirmwareError:
        return []
    return sorted(name for name in names if name.lower().startswith(incomplete.lower()))


@dataclass(frozen=True, slots=True)
class SketchOptions:
    """A sketch, its board, and how to build it."""

    sketch: Path = argument(metavar="SKETCH", type=PATH)
    board: str = option(
        "-b --board BOARD",
        "uno, mega, leonardo, nano, micro ...; nano:atmega328old for a processor; or an FQBN.",
        default="uno",
        show_default=True,
        shell_complete=complete_boards,
    )
    libraries: tuple[Path, ...] = option(
        "-l --library DIR",
        "An Arduino library, or a folder of libraries; searched first; may be repeated.",
        multiple=True,
        type=PATH,
    )
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())
    defines: tuple[str, ...] = option(
        "-D --define NAME[=VALUE]", "Define a macro; may be repeated.", multiple=True
    )
    warnings: bool = flag("--warnings", "Show the compiler's warnings about the sketch.")
    verbose: bool = flag("-v --verbose", "Show every command before it runs.")
    builder: str = option(
        "--with",
        "Build with Debian's compiler (the default), or arduino-cli, which also builds for non-AVR boards.",
        type=click.Choice([AVR_GCC, ARDUINO_CLI]),
        default=AVR_GCC,
    )

    def build_options(self) -> BuildOptions:
        """Return how to build the sketch."""
        return BuildOptions(
            libraries=self.libraries,
            msg_paths=tuple(each.expanduser() for each in self.msg_paths),
            defines=self.defines,
            warnings=self.warnings,
            uses_arduino_cli=self.builder == ARDUINO_CLI,
            show=(lambda command: warn(shlex.join(command))) if self.verbose else None,
        )


sketch_options = option_group("options", SketchOptions)


async def build(options: SketchOptions) -> BuiltFirmware:
    """Build a sketch; the compiler's output goes to stderr unchanged.

    Raises FirmwareError, CodegenError, ConfigError, DefinitionError.
    """
    try:
        board = find_board(options.board)
        waiting = f"building {options.sketch} for {board.title}; this takes a few seconds"
        with reported_when_long(_show_wait, waiting):
            built = await build_sketch(options.sketch, board, options.build_options())
    except SketchError as error:
        warn(error.diagnostics.rstrip("\n"))
        raise
    if built.output.strip():
        warn(built.output.rstrip("\n"))
    return built


def _show_wait(text: str) -> None:
    # Only a person needs a notice; scripts get only the result.
    if sys.stderr.isatty():
        warn(text)
