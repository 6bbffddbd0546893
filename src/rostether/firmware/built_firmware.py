"""The options and the result of a build, with avr-gcc or arduino-cli."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from msgspec import Struct

from rostether.firmware.boards import Board
from rostether.firmware.libraries import Origin, UsedLibrary
from rostether.firmware.sketch import Sketch

# Servo, the other library of simulated boards, also works on real ones.
_ONLY_SIMULATED = ("Ethernet",)


class BuildOptions(Struct, frozen=True):
    """Options of a build besides the sketch and the board.

    `libraries` are folders of one library or of several; `msg_paths` are folders with message definitions;
    `defines` are macros, `NAME` or `NAME=VALUE`; `warnings` turns on compiler warnings for the sketch; `show`
    gets every command line.
    """

    libraries: tuple[Path, ...] = ()
    msg_paths: tuple[Path, ...] = ()
    defines: tuple[str, ...] = ()
    warnings: bool = False
    uses_arduino_cli: bool = False
    show: Callable[[Sequence[str]], None] | None = None


class BuiltFirmware(Struct, frozen=True):
    """The result of a build. `image` is the file to flash; `output` has the compiler's warnings."""

    sketch: Sketch
    board: Board
    elf: Path
    image: Path
    libraries: tuple[UsedLibrary, ...]
    output: str
    duration_s: float
    is_from_cache: bool = False
    sources: tuple[Path, ...] = ()

    @property
    def simulated_libraries(self) -> list[str]:
        """The libraries that work only on simulated boards."""
        return [
            each.name
            for each in self.libraries
            if each.origin is Origin.SIMULATION and each.name in _ONLY_SIMULATED
        ]
