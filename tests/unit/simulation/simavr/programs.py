"""Programs for simulated boards: C files of `firmware/`, built with avr-gcc, and sketches given as text."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from rostether.firmware.build import build_sketch, find_board
from rostether.simulation.simavr.compile import missing_parts

FIRMWARE = Path(__file__).parent / "firmware"
ARDUINO_CORE = Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino")
MCU = {"uno": "atmega328p", "nano": "atmega328p", "mega": "atmega2560", "leonardo": "atmega32u4"}


def missing_simavr() -> str:
    """Return why simulated boards cannot run on this machine; an empty text if they can."""
    if shutil.which("avr-gcc") is None:
        return "no avr-gcc; scripts/install-peers installs gcc-avr and avr-libc"
    if not ARDUINO_CORE.is_dir():
        return "no Arduino core; scripts/install-peers installs arduino-core-avr"
    return missing_parts()


def build(name: str, *defines: str, board: str = "uno") -> Path:
    """Compile a C file of `firmware/` once for all test processes, which may run at the same time."""
    source = FIRMWARE / f"{name}.c"
    flags = [f"-mmcu={MCU[board]}", "-DF_CPU=16000000UL", "-Os", "-std=gnu11", "-Wall", "-Wextra", "-Werror"]
    flags += [f"-D{define}" for define in defines]
    content = hashlib.sha256(repr(flags).encode())
    for file in (source, FIRMWARE / "usart.h"):
        content.update(file.read_bytes())
    folder = Path(tempfile.gettempdir()) / f"rostether-simavr-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    elf = folder / f"{name}-{content.hexdigest()[:16]}.elf"
    if not elf.exists():
        with tempfile.TemporaryDirectory(dir=folder) as fresh:
            made = Path(fresh) / "made.elf"
            subprocess.run(["avr-gcc", *flags, str(source), "-o", str(made)], check=True)
            made.replace(elf)
    return elf


async def build_text(folder: Path, text: str, *, board: str = "uno", name: str = "sketch") -> Path:
    """Build an Arduino sketch."""
    sketch = folder / name / f"{name}.ino"
    sketch.parent.mkdir(exist_ok=True)
    sketch.write_text(text)
    return (await build_sketch(sketch, find_board(board))).elf
