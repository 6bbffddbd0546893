"""Compiles the runner on first use. The runner links libsimavr (GPL-3), so it is a separate program."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from rostether.errors import BoardError, first_error
from rostether.mechanisms.program import run_program
from rostether.mechanisms.user_folders import FolderKind, user_folder
from rostether.mechanisms.whole_file import sync_file

SOURCES = Path(__file__).parent / "runner"
PACKAGES = "gcc libsimavr-dev libelf-dev"
FLAGS = ("-std=gnu11", "-D_GNU_SOURCE", "-O2", "-Wall", "-Wextra")
LIBRARIES = ("-lsimavr", "-lelf", "-lm")
HEADERS = Path("/usr/include/simavr")

# How often a process that waits for the build of another process checks again.
LOCK_POLL_S = 0.05

_COMPILERS = ("cc", "gcc", "clang")
_NAME = "rostether-simavr"


async def build_runner() -> Path:
    """Return the path of the runner; compile it if needed.

    If several processes need it at the same time, one of them compiles it. Raises BoardError with the
    packages to install.
    """
    compiler = _find_compiler()
    sources = sorted(SOURCES.glob("*.c"))
    program = user_folder(FolderKind.CACHE) / "simavr" / f"{_NAME}-{_key(compiler)}"
    if program.exists():
        return program
    try:
        program.parent.mkdir(parents=True, exist_ok=True)
        folder = tempfile.TemporaryDirectory(prefix=f".{_NAME}-", dir=program.parent)
    except OSError as error:
        raise BoardError(
            f"cannot write to {program.parent}: {error.strerror}; set XDG_CACHE_HOME to a writable folder"
        ) from None
    with folder as fresh:
        async with _build_lock(program.parent):
            if not program.exists():
                await _compile(compiler, sources, fresh, program)
    return program


@asynccontextmanager
async def _build_lock(folder: Path) -> AsyncIterator[None]:
    """Wait until no other process builds in a folder; on a file system without locks, do not wait."""
    import fcntl  # Windows lacks this module

    opened = os.open(folder, os.O_RDONLY)
    try:
        while True:
            try:
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                await asyncio.sleep(LOCK_POLL_S)
                continue
            except OSError:
                pass
            break
        yield
    finally:
        os.close(opened)


async def _compile(compiler: str, sources: Sequence[Path], fresh: str, program: Path) -> None:
    objects = [f"{fresh}/{source.stem}.o" for source in sources]
    limit = asyncio.Semaphore(os.cpu_count() or 1)
    try:
        async with asyncio.TaskGroup() as tasks:
            for source, made in zip(sources, objects, strict=True):
                headers = ("-isystem", str(HEADERS))
                command = (compiler, *FLAGS, *headers, "-c", str(source), "-o", made)
                tasks.create_task(_run(command, limit))
    except BaseExceptionGroup as failures:
        raise first_error(failures) from None
    await _run((compiler, *objects, "-o", f"{fresh}/{_NAME}", *LIBRARIES), limit)
    await asyncio.to_thread(sync_file, Path(fresh, _NAME))
    # Replaces the program in one step, so that no process starts an incomplete one.
    os.replace(f"{fresh}/{_NAME}", program)  # noqa: PTH105


def missing_parts() -> str:
    """Return why the runner cannot be compiled on this machine; an empty text if it can."""
    try:
        _find_compiler()
    except BoardError as error:
        return str(error)
    return "" if HEADERS.is_dir() else _advice("libsimavr is not installed")


def _find_compiler() -> str:
    if not sys.platform.startswith("linux"):
        raise BoardError(
            "simulated AVR boards run on Linux only; `rostether demo` has a simulated board in Python"
        )
    wanted = os.environ.get("CC", "").split()[:1] or _COMPILERS
    found = next(filter(None, map(shutil.which, wanted)), None)
    if found is None:
        raise BoardError(_advice("no C compiler is installed"))
    return found


def _advice(reason: str) -> str:
    return f"{reason}, and simulated boards need it; on Debian and Ubuntu: sudo apt install {PACKAGES}"


def _key(compiler: str) -> str:
    """Return the key of a build: a hash of sources, flags, compiler and the simulator's headers."""
    content = hashlib.sha256()
    for path in sorted(SOURCES.glob("*.[ch]")):
        content.update(path.name.encode() + b"\0" + path.read_bytes())
    content.update(repr((FLAGS, LIBRARIES, compiler)).encode())
    with contextlib.suppress(OSError):
        header = (HEADERS / "sim_avr.h").stat()
        content.update(repr((header.st_size, header.st_mtime_ns)).encode())
    return content.hexdigest()[:16]


async def _run(command: Sequence[str], limit: asyncio.Semaphore) -> None:
    async with limit:
        ended = await run_program(command, environ={**os.environ, "LC_ALL": "C"})
    if ended.code:
        raise BoardError(_explain(command[0], ended.output.decode(errors="replace")))


def _explain(compiler: str, text: str) -> str:
    for sign, reason in (
        ("gelf.h", "libelf is not installed"),
        ("-lelf", "libelf is not installed"),
        ("sim_", "libsimavr is not installed"),
        ("avr_", "libsimavr is not installed"),
        ("-lsimavr", "libsimavr is not installed"),
    ):
        if sign in text and ("No such file" in text or "cannot find" in text):
            return _advice(reason)
    first = next((line for line in text.splitlines() if "error" in line), text.strip()[:200])
    return f"the simulated boards' runner does not compile with {compiler}: {first}"
