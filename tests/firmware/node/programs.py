"""The programs of client/extras/tests that test the node on the host; each is compiled once for all
processes.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from rostether.codegen.arduino_library import write_library
from rostether.codegen.library_source import client_library
from rostether.msgdef.registry import Registry

EXTRAS = client_library() / "extras" / "tests"
WARNINGS = ("-std=gnu++11", "-Wall", "-Wextra", "-Werror")
# Messages of the undefined behavior sanitizer would double the time to compile: it traps, and the address
# sanitizer names the function.
_SANITIZERS = ("-fsanitize=address,undefined", "-fsanitize-undefined-trap-on-error")
# clang's address sanitizer is in a separate package. `char` is unsigned, as on an ARM.
COMPILERS = {
    "gcc": ("g++", *_SANITIZERS),
    # As on an AVR, where chunks are in the unused space of the receive window.
    "gcc-small": ("g++", *_SANITIZERS, "-DROS_SMALL_MEMORY"),
    "clang": ("clang++", "-fsanitize=undefined", "-fsanitize-trap=all", "-funsigned-char"),
}
KEPT_S = 3600.0  # other test processes may still run an older program


def write_test_library(folder: Path) -> Path:
    """Write the client library with the types that the programs use; return its folder."""
    return write_library(folder, Registry([EXTRAS / "definitions"])).path


def build_program(compiler: str, name: str, library: Path, *flags: str) -> Path:
    """Build the program of a folder of extras/tests and return it; fail with the compiler's messages."""
    sources = sorted((EXTRAS / name).glob("*.cpp"))
    command = [*COMPILERS[compiler], *flags, *WARNINGS]
    folder = Path(tempfile.gettempdir()) / f"rostether-peers-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    program = folder / f"{name}-{_digest(command, library)}"
    with (folder / f"{name}-{compiler}-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not program.exists():
            for old in folder.glob(f"{name}-????????????????"):
                # A process with another compiler may remove it too.
                with contextlib.suppress(FileNotFoundError):
                    if old.stat().st_mtime < time.time() - KEPT_S:
                        old.unlink()
            with tempfile.TemporaryDirectory() as work:
                _build([*command, f"-I{library}/src"], sources, Path(work), program)
    return program


def run(program: Path, *arguments: str, stdin: str = "", timeout_s: float = 50.0) -> str:
    """Run a program to its end; fail with its error messages."""
    completed = subprocess.run(
        [program, *arguments],
        env={"ASAN_OPTIONS": "handle_sigill=1"},
        input=stdin,
        capture_output=True,
        text=True,
        timeout=timeout_s,
    )
    assert completed.returncode == 0, f"exit code {completed.returncode}\n{completed.stderr[-4000:]}"
    return completed.stdout


def _digest(command: Sequence[str], library: Path) -> str:
    content = hashlib.sha256(repr(command).encode())
    for file in [*sorted((library / "src").rglob("*.h")), *sorted(EXTRAS.rglob("*.*"))]:
        content.update(file.read_bytes())
    return content.hexdigest()[:16]


def _build(command: Sequence[str], sources: Sequence[Path], work: Path, program: Path) -> None:
    whole, unfinished = work / "whole.cpp", work / "program"
    whole.write_text(_join_sources(sources))
    completed = subprocess.run([*command, str(whole), "-o", str(unfinished)], capture_output=True, text=True)
    assert completed.returncode == 0 and not completed.stderr, completed.stderr
    os.replace(unfinished, program)  # noqa: PTH105 - at once, so that a program is never started half-written


def _join_sources(sources: Sequence[Path]) -> str:
    """Return one source that includes all others, so that common templates are compiled once.

    Each source except the one with `main` is in a namespace, so names may repeat. Their headers are included
    before.
    """
    headers = {
        line for file in sources for line in file.read_text().splitlines() if line.startswith("#include <")
    }
    lines = sorted(headers) + [f'#include "{each}"' for each in sorted(sources[0].parent.glob("*.h"))]
    for file in sources:
        include = f'#include "{file}"'
        has_main = file.stem == "main" or len(sources) == 1
        lines += [include] if has_main else [f"namespace {file.stem} {{", include, "}"]
    return "\n".join(lines) + "\n"
