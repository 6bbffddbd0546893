"""Finds the compiler, the Arduino core and the flashing programs, or names the packages to install."""

from __future__ import annotations

import glob
import os
import shutil
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

from msgspec import Struct

from rostether.errors import FirmwareError
from rostether.firmware.boards import Board, BoardTable
from rostether.firmware.properties import command_line, expand, parse_properties

# The value of the macro `ARDUINO`: the last version of IDE 1, which libraries compare against.
IDE_VERSION = 10819

INSTALL_LINE = "sudo apt install gcc-avr avr-libc arduino-core-avr"
# Debian's package, an unpacked IDE, and the downloads of arduino-cli and the IDE.
CORE_FOLDERS = (
    "/usr/share/arduino/hardware/arduino/avr",
    "/usr/local/share/arduino/hardware/arduino/avr",
    "~/.arduino15/packages/arduino/hardware/avr/*",
    "~/Library/Arduino15/packages/arduino/hardware/avr/*",
)

_TOOL_FOLDERS = (
    "~/.arduino15/packages/arduino/tools/avr-gcc/*/bin",
    "~/Library/Arduino15/packages/arduino/tools/avr-gcc/*/bin",
)
# Core 1.8.7 prints floating point numbers with a macro that gcc 5 defines only under another name.
_CPP_EXTRA_FLAGS = "-DDECIMAL_DIG=__DECIMAL_DIG__"
# STABS, the default of old compilers, has no information about inlined code; new compilers dropped it.
_DEBUG_FLAG = "-gdwarf-2"


class AvrToolchain(Struct, frozen=True, dict=True):
    """The folders of a compiler's programs and of a compatible core."""

    tools: Path
    core: Path

    @cached_property
    def properties(self) -> dict[str, str]:
        """The properties of platform.txt, with rostether's flags in the user's properties."""
        return parse_properties((self.core / "platform.txt").read_text(encoding="utf-8")) | {
            "compiler.path": f"{self.tools}/",
            "compiler.c.extra_flags": _DEBUG_FLAG,
            "compiler.cpp.extra_flags": f"{_CPP_EXTRA_FLAGS} {_DEBUG_FLAG}",
            "compiler.S.extra_flags": _DEBUG_FLAG,
            "compiler.c.elf.extra_flags": _DEBUG_FLAG,
            "runtime.ide.version": str(IDE_VERSION),
            "runtime.platform.path": str(self.core),
            "build.arch": "AVR",
        }

    @cached_property
    def boards(self) -> BoardTable:
        """The boards of this core."""
        return BoardTable((self.core / "boards.txt").read_text(encoding="utf-8"))

    @cached_property
    def identity(self) -> str:
        """A string that changes with the version of the compiler or the core."""
        compiler = (self.tools / "avr-gcc").resolve()
        status = compiler.stat()
        platform = (self.core / "platform.txt").stat()
        return f"{compiler} {status.st_size} {status.st_mtime_ns} {self.core} {platform.st_mtime_ns}"

    def recipe(self, name: str, board: Board, warnings: str = "none") -> list[str]:
        """Return a recipe's command line for a board; `warnings` is `none`, `default`, `more` or `all`."""
        properties = {**self.properties, **board.properties}
        properties["compiler.warning_flags"] = self.properties.get(f"compiler.warning_flags.{warnings}", "")
        properties["build.extra_flags"] = expand(properties.get("build.extra_flags", ""), properties)
        return command_line(self.properties[f"recipe.{name}.pattern"], properties)

    def core_folders(self, board: Board) -> tuple[Path, Path]:
        """Return the folders of the core's sources and of the board's pin table."""
        return (
            self.core / "cores" / board.properties.get("build.core", "arduino"),
            self.core / "variants" / board.properties.get("build.variant", "standard"),
        )

    @property
    def libraries(self) -> Path:
        """The folder of the core's libraries (Wire, SPI, SoftwareSerial, EEPROM)."""
        return self.core / "libraries"


def find_avr_toolchain(
    environ: Mapping[str, str] | None = None, core_folders: tuple[str, ...] = CORE_FOLDERS
) -> AvrToolchain:
    """Return the compiler on PATH or in an Arduino installation, and the first core that exists.

    Raises FirmwareError, which names the packages to install.
    """
    path = (os.environ if environ is None else environ).get("PATH")
    compiler = shutil.which("avr-g++", path=path)
    tools = [Path(compiler).parent] if compiler else _existing(_TOOL_FOLDERS)
    if not tools:
        raise FirmwareError(f"no AVR compiler (avr-gcc) on PATH; run: {INSTALL_LINE}; or install arduino-cli")
    cores = [folder for folder in _existing(core_folders) if (folder / "boards.txt").is_file()]
    if not cores:
        raise FirmwareError(f"no Arduino core for AVR boards in {core_folders[0]}; run: {INSTALL_LINE}")
    return AvrToolchain(tools[0], cores[0])


def find_arduino_cli(reason: str, environ: Mapping[str, str] | None = None) -> str:
    """Return the path of arduino-cli. Raises FirmwareError; `reason` is what needs it, such as a build."""
    program = shutil.which("arduino-cli", path=(os.environ if environ is None else environ).get("PATH"))
    if program is None:
        raise FirmwareError(
            f"{reason} needs arduino-cli, which is not on PATH; see https://arduino.github.io/arduino-cli"
        )
    return program


def _existing(patterns: tuple[str, ...]) -> list[Path]:
    # The newest version comes first, by name.
    return [
        Path(found)
        for pattern in patterns
        for found in sorted(glob.glob(os.path.expanduser(pattern)), reverse=True)  # noqa: PTH111, PTH207
        if Path(found).is_dir()
    ]
