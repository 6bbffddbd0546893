"""Builds sketches for the board OpenCR as Linux programs, which the simulated board runs."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from rostether.errors import FirmwareError, SketchError
from rostether.firmware.cache import BuildCache, cache_folder, digest
from rostether.firmware.ino import add_prototypes, read_ino
from rostether.firmware.ros_library import RosLibrary
from rostether.firmware.sketch import included_headers, open_sketch
from rostether.mechanisms.program import run_program

_COMPILER = "g++"

# The time limit of servos is long, because simulated servos answer late on a busy machine.
FLAGS = (
    *("-std=gnu++11", "-O1", "-Wall", "-Wextra"),
    *("-DARDUINO=10819", "-D__OPENCR__", "-DDYNAMIXEL_TIMEOUT_US=200000"),
)

_KIND = "opencr"
_PROGRAM = "sketch"
_SOURCES = (".h", ".hpp", ".c", ".cpp", ".cc", ".cxx", ".ino", ".pde")


async def build_for_linux(sketch: Path, msg_paths: Sequence[Path] = ()) -> Path:
    """Return the program of an .ino file or a folder with one, compiled if necessary.

    `msg_paths` are folders with message definitions. Raises FirmwareError when there is no such sketch or no
    compiler, SketchError when it does not compile, CodegenError, DefinitionError.
    """
    from rostether.codegen.library_source import client_library

    compiler = shutil.which(_COMPILER)
    if not sys.platform.startswith("linux"):
        raise FirmwareError("the simulated OpenCR runs on Linux only; use the real board here")
    if compiler is None:
        raise FirmwareError(
            f"{_COMPILER} is not installed, and the simulated OpenCR needs it; on Debian and Ubuntu: "
            "sudo apt install g++"
        )
    found = open_sketch(sketch)
    cache = BuildCache(cache_folder())
    ros = RosLibrary(cache, found.definition_folders(msg_paths))
    files = found.files(_SOURCES)
    for header in included_headers(files):
        ros.add_header(header)
    library = ros.write()
    core = client_library() / "extras" / "opencr_on_linux"
    key = digest(
        *(FLAGS, compiler, str(library.folder)),
        *map(str, files),
        *(cache.file_digest(each) for each in [*files, *sorted(core.iterdir())]),
    )
    known = cache.find(_KIND, key, _PROGRAM)
    if known is not None:
        return known
    with cache.filling(_KIND, key) as folder:
        main = folder / "main.cpp"
        text = add_prototypes([read_ino(each) for each in found.inos], None)
        main.write_text(text, encoding="utf-8", errors="surrogateescape")
        sources = [main, *found.sources, core / "board.cpp"]
        includes = [f"-I{each}" for each in (core, found.folder, *library.include_folders)]
        command = [compiler, *FLAGS, *includes, *map(str, sources), "-o", str(folder / _PROGRAM)]
        ended = await run_program(command, environ={**os.environ, "LC_ALL": "C"})
        if ended.code:
            raise SketchError(
                f"{found.name} does not build for the simulated OpenCR",
                diagnostics=ended.output.decode(errors="replace"),
            )
    return cache.path(_KIND, key, _PROGRAM)
