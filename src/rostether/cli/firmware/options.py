"""The common part of `firmware build`, `size`, `upload` and `sim`: their options, and running a build."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.completions import complete_ports
from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.option_group import PATH, option_group
from rostether.cli.shell.output import warn
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.errors import SketchError

if TYPE_CHECKING:
    from rostether.firmware.build import BuildOptions, BuiltFirmware

DEFAULT_BOARD = "uno"
ARDUINO_CLI = "arduino-cli"
AVR_GCC = "avr-gcc"


def complete_boards(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the boards that begin with the typed text."""
    from rostether.errors import FirmwareError
    from rostether.firmware.toolchain import find_avr_toolchain

    try:
        names = find_avr_toolchain().boards.names
    except FirmwareError:
        return []
    return sorted(name for name in names if name.lower().startswith(incomplete.lower()))


board_option = click.option(
    "-b",
    "--board",
    "board_name",
    default=DEFAULT_BOARD,
    show_default=True,
    metavar="BOARD",
    shell_complete=complete_boards,
    help="uno, mega, leonardo, nano, micro ...; nano:atmega328old for a processor; or an FQBN.",
)


port_option = click.option(
    "-p",
    "--port",
    shell_complete=complete_ports,
    metavar="PORT",
    help="The board's serial port (default: the only one found).",
)


async def build(sketch: Path, board_name: str, options: BuildOptions) -> BuiltFirmware:
    """Build a sketch; the compiler's output goes to stderr unchanged."""
    from rostether.firmware.build import build_sketch, find_board

    try:
        board = find_board(board_name)
        with reported_when_long(_show_wait, f"building {sketch} for {board.title}; this takes some seconds"):
            built = await build_sketch(sketch, board, options)
    except SketchError as error:
        warn(error.diagnostics.rstrip("\n"))
        raise
    if built.output.strip():
        warn(built.output.rstrip("\n"))
    return built


def _show_wait(text: str) -> None:
    # Only people wait; the output of scripts stays as it is.
    if sys.stderr.isatty():
        warn(text)


def _show(command: Sequence[str]) -> None:
    warn(shlex.join(command))


_OPTIONS: tuple[Callable[[Any], Any], ...] = (
    click.argument("sketch", metavar="SKETCH", type=PATH),
    board_option,
    click.option(
        "-l",
        "--library",
        "libraries",
        multiple=True,
        metavar="DIR",
        type=PATH,
        help="An Arduino library, or a folder of libraries; searched first; may be repeated.",
    ),
    msg_path_option,
    click.option(
        "-D",
        "--define",
        "defines",
        multiple=True,
        metavar="NAME[=VALUE]",
        help="Define a macro; may be repeated.",
    ),
    click.option("--warnings", is_flag=True, help="Show the compiler's warnings about the sketch."),
    click.option("-v", "--verbose", is_flag=True, help="Show every command before it runs."),
    click.option(
        "--with",
        "builder",
        type=click.Choice([AVR_GCC, ARDUINO_CLI]),
        default=AVR_GCC,
        help="Build with Debian's compiler (the default) or arduino-cli, also for boards without an AVR.",
    ),
)


def _build_options(
    *,
    libraries: tuple[Path, ...] = (),
    msg_paths: tuple[Path, ...] = (),
    defines: tuple[str, ...] = (),
    warnings: bool = False,
    verbose: bool = False,
    builder: str = AVR_GCC,
) -> BuildOptions:
    from rostether.firmware.build import BuildOptions

    return BuildOptions(
        libraries=libraries,
        msg_paths=tuple(each.expanduser() for each in msg_paths),
        defines=defines,
        warnings=warnings,
        uses_arduino_cli=builder == ARDUINO_CLI,
        show=_show if verbose else None,
    )


# Adds the sketch, as `sketch`, its board, as `board_name`, and the options of the build, as `options`.
build_options = option_group("options", _build_options, _OPTIONS)
