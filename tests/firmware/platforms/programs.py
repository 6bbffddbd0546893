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
WARNINGS = ("-std=gnu++11", "-Wall", "-Wextra", "-Werror")


def compile_program(
    command: Sequence[str], sources: Sequence[Path], library: Path, output: Path, *after: str
) -> Path:
    """Compile and link sources against a generated library; fails with what the compiler says."""
    output.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        [*command, *WARNINGS, f"-I{library}/src", *map(str, sources), "-o", str(output), *after],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr, done.stderr
    return output


def compile_for_cortex_m(source: Path, library: Path, output: Path, *flags: str) -> Path:
    """Compile a program for qemu's Stellaris, with the platform header of the Tiva C."""
    command = [
        *("arm-none-eabi-g++", "-mcpu=cortex-m3", "-mthumb", "-Os", "-ffunction-sections", "-fdata-sections"),
        *("-fno-exceptions", "-fno-rtti", "-nostartfiles", "-Wl,--gc-sections"),
        *("-T", str(CORTEX_M / "lm3s6965.ld"), "-DPART_TM4C123GH6PM"),
        *(f"-I{STUBS}/tivaware", f"-I{CORTEX_M}", *flags),
    ]
    return compile_program(
        command, [source, CORTEX_M / "startup.cpp", CORTEX_M / "driverlib.cpp"], library, output
    )


@contextlib.asynccontextmanager
async def running(
    *command: str | Path, environment: Mapping[str, str] | None = None
) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run a program for as long as the block lasts."""
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
