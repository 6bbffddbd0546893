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
from rostether.cli.shell.option_group import PATH, add_flag, add_option, option_group
from rostether.cli.shell.output import warn
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.errors import SketchError

if TYPE_CHECKING:
    from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware

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


board_option = add_option(
    "-b --board board_name BOARD",
    "uno, mega, leonardo, nano, micro ...; nano:atmega328old for a processor; or an FQBN.",
    default=DEFAULT_BOARD,
    show_default=True,
    shell_complete=complete_boards,
)


port_option = add_option(
    "-p --port PORT", "The board's serial port (default: the only one found).", shell_complete=complete_ports
)


async def build(sketch: Path, board_name: str, options: BuildOptions) -> BuiltFirmware:
    """Build a sketch; the compiler's output goes to stderr unchanged."""
    from rostether.firmware.build import build_sketch, find_board

    try:
        board = find_board(board_name)
        with reported_when_long(_show_wait, f"building {sketch} for {board.title}; this takes a few seconds"):
            built = await build_sketch(sketch, board, options)
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


def _show(command: Sequence[str]) -> None:
    warn(shlex.join(command))


_OPTIONS: tuple[Callable[[Any], Any], ...] = (
    click.argument("sketch", metavar="SKETCH", type=PATH),
    board_option,
    add_option(
        "-l --library libraries DIR",
        "An Arduino library, or a folder of libraries; searched first; may be repeated.",
        multiple=True,
        type=PATH,
    ),
    msg_path_option,
    add_option("-D --define defines NAME[=VALUE]", "Define a macro; may be repeated.", multiple=True),
    add_flag("--warnings", "Show the compiler's warnings about the sketch."),
    add_flag("-v --verbose", "Show every command before it runs."),
    add_option(
        "--with builder",
        "Build with Debian's compiler (the default), or arduino-cli, which also builds for non-AVR boards.",
        type=click.Choice([AVR_GCC, ARDUINO_CLI]),
        default=AVR_GCC,
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
    from rostether.firmware.built_firmware import BuildOptions

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
