"""Builds and runs the programs of client/extras/tests."""

from __future__ import annotations

import asyncio
import contextlib
import os
import subprocess
from collections.abc import AsyncIterator, Mapping, Sequence
from pathlib import Path

from rostether.codegen.library_source import client_library

EXTRAS = client_library() / "extras" / "tests"
NODE = EXTRAS / "platforms"
EXAMPLES = client_library() / "examples"
STUBS = EXTRAS / "stubs"
CORTEX_M = EXTRAS / "cortexm"
LX106 = EXTRAS / "lx106"
RP2040 = EXTRAS / "rp2040"
WARNINGS = ("-std=gnu++11", "-Wall", "-Wextra", "-Werror")


def compile_program(
    command: Sequence[str], sources: Sequence[Path], library: Path, output: Path, *after: str
) -> Path:
    """Compile and link sources against a generated library; fail with the compiler's messages."""
    output.parent.mkdir(parents=True, exist_ok=True)
    completed = subprocess.run(
        [*command, *WARNINGS, f"-I{library}/src", *map(str, sources), "-o", str(output), *after],
        capture_output=True,
        text=True,
    )
    assert completed.returncode == 0, completed.stderr
    assert not completed.stderr, completed.stderr
    return output


def compile_for_cortex_m(source: Path, library: Path, output: Path, *flags: str) -> Path:
    """Compile a program for qemu's Stellaris, with the platform header of the Tiva C."""
    kit = ("-DPART_TM4C123GH6PM", f"-I{STUBS}/tivaware")
    return _compile_for_core(
        "cortex-m3", "lm3s6965.ld", "driverlib.cpp", source, library, output, *kit, *flags
    )


# The kits that have replacements for an STM32F405: the file with their functions, and the flags of their
# programs.
STM32_KITS = {
    "ST's HAL": ("stm32_hal.cpp", ("-DUSE_HAL_DRIVER", f"-I{STUBS}/stm32")),
    "Mbed 2": ("mbed_kit.cpp", ("-D__MBED__", f"-I{STUBS}/mbed2")),
    "Mbed 6": ("mbed_kit.cpp", ("-D__MBED__", f"-I{STUBS}/mbed6", "-std=gnu++14")),
}


def compile_for_stm32(kit: str, source: Path, library: Path, output: Path) -> Path:
    """Compile a program for qemu's STM32F405, with the platform header of one of STM32_KITS."""
    calls, flags = STM32_KITS[kit]
    return _compile_for_core("cortex-m4", "stm32f405.ld", calls, source, library, output, *flags)


def compile_for_esp8266(source: Path, library: Path, output: Path) -> Path:
    """Compile a sketch with the ESP8266's compiler, for its processor core on a board that qemu simulates."""
    # Debian's picolibc.
    libc = Path("/usr/lib/xtensa-lx106-elf")
    command = [
        *("xtensa-lx106-elf-g++", "-Os", "-mlongcalls", "-ffunction-sections", "-fdata-sections"),
        *("-fno-exceptions", "-fno-rtti", "-nostdlib", "-Wl,--gc-sections", "-T", str(LX106 / "esp8266.ld")),
        *("-isystem", str(libc / "include"), "-DARDUINO=10819", "-DESP8266", "-DESP_SERIAL"),
        f"-I{STUBS}/arduino",
    ]
    sources = [source, LX106 / "esp8266_core.cpp", LX106 / "start.S"]
    return compile_program(command, sources, library, output, "-L", str(libc / "lib"), "-lc", "-lgcc")


def compile_for_rp2040(source: Path, library: Path, output: Path) -> Path:
    """Compile a sketch for an RP2040; return the image of its flash."""
    flags = ("-DARDUINO=10819", "-DARDUINO_ARCH_RP2040", f"-I{STUBS}/arduino", "-L", str(RP2040))
    program = _compile_for_core(
        "cortex-m0plus",
        "rp2040.ld",
        str(RP2040 / "rp2040_core.cpp"),
        source,
        library,
        output.with_suffix(".elf"),
        *flags,
    )
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", program, output], check=True)
    return output


def _compile_for_core(
    core: str, memory: str, kit: str, source: Path, library: Path, output: Path, *flags: str
) -> Path:
    command = [
        *("arm-none-eabi-g++", f"-mcpu={core}", "-mthumb", "-Os", "-ffunction-sections", "-fdata-sections"),
        *("-fno-exceptions", "-fno-rtti", "-nostartfiles", "-Wl,--gc-sections"),
        *("-L", str(CORTEX_M), "-T", memory, f"-I{CORTEX_M}", *flags),
    ]
    return compile_program(command, [source, CORTEX_M / "startup.cpp", CORTEX_M / kit], library, output)


@contextlib.asynccontextmanager
async def running(
    *command: str | Path, environment: Mapping[str, str] | None = None
) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run a program until the block ends."""
    process = await asyncio.create_subprocess_exec(
        *map(str, command),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.DEVNULL,
        env={**os.environ, **(environment or {})},
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()
