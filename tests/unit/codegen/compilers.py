"""The C++ compilers that the client library supports, with the flags with which it must compile without a
warning.
"""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

WARNINGS = ("-std=gnu++11", "-Wall", "-Wextra", "-Werror")
ARDUINO_CORE = Path("/usr/share/arduino/hardware/arduino/avr")


@dataclass(frozen=True, slots=True)
class Compiler:
    """A compiler; `prelude` are the system headers whose macros must not break generated names."""

    program: str
    package: str
    flags: tuple[str, ...]
    prelude: tuple[str, ...]

    def compile(self, source: Path, library: Path, output: Path | None = None) -> str:
        """Compile one file against a library, to an object file or as a check; return the compiler's
        messages.
        """
        includes = [part for header in self.prelude for part in ("-include", header)]
        target = ["-c", "-o", str(output)] if output is not None else ["-fsyntax-only"]
        done = subprocess.run(
            [self.program, *WARNINGS, *self.flags, f"-I{library}/src", *includes, *target, str(source)],
            capture_output=True,
            text=True,
        )
        return done.stderr if done.returncode or done.stderr else ""


_AVR_FLAGS = (
    *("-Os", "-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DDECIMAL_DIG=__DECIMAL_DIG__"),
    *(f"-I{ARDUINO_CORE}/cores/arduino", f"-I{ARDUINO_CORE}/variants/standard"),
)
COMPILERS = {
    "gcc": Compiler("g++", "g++", (), ("errno.h", "math.h", "stdio.h", "termios.h")),
    "clang": Compiler("clang++", "clang", (), ("errno.h", "math.h", "stdio.h", "termios.h")),
    "avr": Compiler("avr-g++", "gcc-avr avr-libc arduino-core-avr", _AVR_FLAGS, ("Arduino.h",)),
    "arm": Compiler(
        "arm-none-eabi-g++",
        "gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib",
        ("-mcpu=cortex-m4", "-mthumb"),
        ("errno.h", "math.h", "stdio.h"),
    ),
    "mingw": Compiler(
        "x86_64-w64-mingw32-g++",
        "g++-mingw-w64-x86-64-posix",
        ("-DWIN32_LEAN_AND_MEAN", "-DNOMINMAX"),
        ("winsock2.h", "windows.h"),
    ),
}


def missing_compiler(name: str) -> str:
    """Return why a compiler cannot be used on this machine, or an empty string."""
    compiler = COMPILERS[name]
    found = shutil.which(compiler.program) is not None and (name != "avr" or ARDUINO_CORE.is_dir())
    return "" if found else f"no {compiler.program} (apt install {compiler.package})"
