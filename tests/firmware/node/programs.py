"""The programs of client/extras/tests that test the node on the host, compiled once for all processes."""

from __future__ import annotations

import fcntl
import hashlib
import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from rostether.codegen.arduino_library import write_library
from rostether.codegen.library_source import client_library
from rostether.msgdef.registry import Registry

EXTRAS = client_library() / "extras" / "tests"
WARNINGS = ("-std=gnu++11", "-Wall", "-Wextra", "-Werror")
# clang's sanitizers are packages of their own: it traps instead, and takes char for unsigned, as an ARM does.
COMPILERS = {
    "gcc": ("g++", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
    # As on an AVR, where chunks lie in the room that the receive window lends.
    "gcc-small": ("g++", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DROS_SMALL_MEMORY"),
    "clang": ("clang++", "-fsanitize=undefined", "-fsanitize-trap=all", "-funsigned-char"),
}
KEPT_S = 3600.0  # other test processes may be running an older program


def write_test_library(folder: Path) -> Path:
    """Write the client library with the types that the programs use; returns its folder."""
    return write_library(folder, Registry([EXTRAS / "definitions"])).path


def built(compiler: str, name: str, library: Path, *flags: str) -> Path:
    """Return the program of a folder of extras/tests; fails with what the compiler says."""
    sources = sorted((EXTRAS / name).glob("*.cpp"))
    command = [*COMPILERS[compiler], *flags, *WARNINGS]
    folder = Path(tempfile.gettempdir()) / f"rostether-peers-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    program = folder / f"{name}-{_digest(command, library)}"
    with (folder / f"{name}-{compiler}-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not program.exists():
            for old in folder.glob(f"{name}-????????????????"):
                if old.stat().st_mtime < time.time() - KEPT_S:
                    old.unlink()
            with tempfile.TemporaryDirectory() as objects:
                _build([*command, f"-I{library}/src"], sources, Path(objects), program)
    return program


def run(program: Path, *arguments: str, stdin: str = "", timeout_s: float = 50.0) -> str:
    """Run a program to its end; fails with what it complains."""
    done = subprocess.run(
        [program, *arguments], input=stdin, capture_output=True, text=True, timeout=timeout_s
    )
    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stderr[-4000:]}"
    return done.stdout


def _digest(command: Sequence[str], library: Path) -> str:
    content = hashlib.sha256(repr(command).encode())
    for file in [*sorted((library / "src").rglob("*.h")), *sorted(EXTRAS.rglob("*.*"))]:
        content.update(file.read_bytes())
    return content.hexdigest()[:16]


def _build(command: Sequence[str], sources: Sequence[Path], objects: Path, program: Path) -> None:
    def compile_one(source: Path) -> Path:
        output = objects / f"{source.stem}.o"
        _say([*command, "-c", str(source), "-o", str(output)])
        return output

    with ThreadPoolExecutor(2) as pool:
        compiled = list(pool.map(compile_one, sources))
    unfinished = objects / "program"
    _say([*command, *map(str, compiled), "-o", str(unfinished)])
    os.replace(unfinished, program)  # noqa: PTH105 - at once, so that nobody starts half a program


def _say(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
